// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/halftone/halftone.h"
#include "api/image/image_codec.h"
#include "core/halftone/inks/separation.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {

inline constexpr api::Limits kHalftoneLimits = {.max_sites = 1'000, .max_pixels = 4'096};

/// Checks that all options of a parsed request are within their ranges, and that it has an image.
inline void check_request(const api::HalftoneRequest& request) {
    CCDT_CHECK(!request.sites || (*request.sites >= 1 && *request.sites <= kHalftoneLimits.max_sites));
    CCDT_CHECK(request.run.seed < std::uint64_t{1} << 53);
    CCDT_CHECK(request.run.iterations >= 0 && request.run.iterations <= 1000);
    CCDT_CHECK(request.run.passes >= 1 && request.run.passes <= 100);
    CCDT_CHECK(!request.scale || (*request.scale >= 0.1 && *request.scale <= 16));
    CCDT_CHECK(!request.dot || (request.dot->length > 0 && request.dot->length <= 65536));
    const api::Palette& palette = request.palette;
    CCDT_CHECK(!palette.inks.empty() && palette.inks.size() <= kMaxInks);
    CCDT_CHECK(palette.mixing != api::Mixing::Cover || palette.inks.size() == 1);
    CCDT_CHECK(palette.mixing == api::Mixing::Cover || request.dots != api::Dots::Paper);
    CCDT_CHECK(request.dots != api::Dots::Both || request.tone != Tone::Density);
    CCDT_CHECK(request.dots != api::Dots::Both || request.drawing.style == api::DotStyle::Fill);
    CCDT_CHECK(palette.mixing != api::Mixing::Add || palette.paper == api::kBlack);
    for (const api::Ink& ink : palette.inks) CCDT_CHECK(!ink.colour.transparent);
    CCDT_CHECK(request.format != nullptr);
    CCDT_CHECK(request.image.header.pixels() >= 1);
}

}  // namespace ccdt::fuzz
