#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// Pixels of a picture, some of which are marked.
struct PixelSet {
    int width = 0;             ///< >= 1
    int height = 0;            ///< >= 1
    std::vector<bool> marked;  ///< [width * height], the first row at the top
};

/// Traces the border of a set of pixels, stretched over a box: chains of edges along their sides, of which none crosses
/// itself or another. Where two marked pixels touch at a corner alone, two chains do.
///
/// @param most  corners
/// @returns     none if there are more corners than that
/// Edges in one line of pixels have one coordinate to the last digit, those along the box that of its side. O(pixels).
std::optional<Area> outline_of(const PixelSet& pixels, const Box& box, std::size_t most);

}  // namespace ccdt
