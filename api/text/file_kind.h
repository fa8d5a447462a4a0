// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace ccdt::api {

/// Returns the kind of a file that the project does not read, for messages: a noun phrase such as "a GeoPackage". The
/// first bytes determine the kind, and for XML the name of the root element.
/// @returns  empty for an unknown kind
std::string_view kind_of_file(std::string_view bytes);

/// Returns whether a file begins like a text: without control characters other than blanks.
bool is_text(std::string_view bytes);

}  // namespace ccdt::api
