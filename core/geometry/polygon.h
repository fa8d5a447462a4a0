// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/geometry/point.h"

namespace ccdt {

/// Corners of a closed chain of segments; the last corner is joined to the first.
using Ring = std::vector<Point>;

/// Rings that together enclose an area by the even-odd rule; they may cross, touch and overlap.
using Area = std::vector<Ring>;

/// A part of a domain as callers give it: rings of either orientation, open or closed (first corner repeated at the
/// end).
struct PolygonPart {
    Ring outer;
    std::vector<Ring> holes;
};

}  // namespace ccdt
