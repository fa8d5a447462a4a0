// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// The pixels of a picture, some of which are marked.
struct PixelSet {
    int width = 0;             ///< >= 1
    int height = 0;            ///< >= 1
    std::vector<bool> marked;  ///< [width * height], row by row from the top
};

/// Traces the border of the marked pixels as closed chains of axis-parallel edges. The picture is scaled to fill `box`.
/// No chain crosses itself or another. Where two marked pixels touch only at a corner, the chains around them touch.
///
/// @param most  limit on the number of corners
/// @returns     none if there are more corners than `most`
///
/// Corners on the same pixel row or column share that coordinate exactly; corners on a side of the box have exactly the
/// coordinate of this side. O(pixels).
std::optional<Area> outline_of(const PixelSet& pixels, const Box& box, std::size_t most);

}  // namespace ccdt
