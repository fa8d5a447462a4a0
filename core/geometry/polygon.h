#pragma once

#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

/// Corners of a closed chain of segments; the last one is joined to the first.
using Ring = std::vector<Point>;

/// Rings that all together enclose, by the even-odd rule, one area; they may meet as they like.
using Area = std::vector<Ring>;

/// A part of a domain as callers give it: rings open or closed (first corner repeated), any orientation.
struct PolygonPart {
    Ring outer;
    std::vector<Ring> holes;
};

}  // namespace ccdt
