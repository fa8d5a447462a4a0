// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace ccdt::server {

/// Parses a whole number.
/// Errors: Malformed; the message describes the valid values, such as "a whole number from 1 to 1024".
Result<std::size_t> parse_whole(std::string_view text, std::uint64_t low, std::uint64_t high);

/// Parses a number of bytes of at most 1 TiB, with an optional unit KiB, MiB or GiB.
/// @param low  smallest number without a unit
/// Errors: Malformed; the message describes the valid values.
Result<std::size_t> parse_bytes(std::string_view text, std::uint64_t low = 1);

/// Formats a number of bytes in the largest unit that fits, rounded to a tenth of it, such as "64MiB" or "11.7GiB".
std::string format_bytes(std::size_t bytes);

/// Returns the hint for a name that is not in a list: the question whether a similar name was meant, or a reference to
/// --help.
std::string suggestion(std::span<const std::string> names, std::string_view misspelt);

}  // namespace ccdt::server
