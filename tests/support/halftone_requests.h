// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "api/halftone/halftone.h"

namespace ccdt::api {

/// Reads a request by read_halftone() or read_halftone_json(), and then parses its options. Errors: those of reading
/// and of parsing.
inline Result<HalftoneRequest> parse_halftone(std::string_view image, const std::vector<TextOption>& options,
                                              std::string_view accept, const Limits& limits) {
    return parse_halftone(read_halftone(image, options, limits), accept, limits);
}

inline Result<HalftoneRequest> parse_halftone_json(std::string_view body, const std::vector<TextOption>& options,
                                                   std::string_view accept, const Limits& limits) {
    const auto input = read_halftone_json(body, options, limits);
    if (!input) return tl::unexpected(input.error());
    return parse_halftone(*input, accept, limits);
}

}  // namespace ccdt::api
