// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace ccdt::api {

/// Encodes bytes as base64 (RFC 4648, section 4), with padding and without line breaks.
std::string base64(std::string_view bytes);

}  // namespace ccdt::api
