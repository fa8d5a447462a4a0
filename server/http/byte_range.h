// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace ccdt::server {

/// A part of a body.
struct ByteRange {
    std::size_t first = 0;
    std::size_t length = 0;  ///< 0: the body has none of the bytes

    friend bool operator==(const ByteRange&, const ByteRange&) = default;
};

/// Reads a Range header (RFC 9110, 14.1.2).
/// @param size  bytes of the body
/// @returns     none if the header is to be ignored: it is empty, malformed, or asks for several ranges
std::optional<ByteRange> parse_range(std::string_view range, std::size_t size);

}  // namespace ccdt::server
