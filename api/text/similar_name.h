// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace ccdt::api {

/// Finds the name that differs from a misspelt one by the fewest characters that are inserted, deleted or replaced.
/// Letters of ASCII count as equal in lower and upper case.
/// @returns  null if all names differ by more than two characters; long names are not compared
const std::string* find_similar(std::span<const std::string> names, std::string_view misspelt);

}  // namespace ccdt::api
