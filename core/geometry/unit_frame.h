// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/point.h"

namespace ccdt {

/// The frame in which the longer side of a box is 1 and the lower left corner is the origin.
struct UnitFrame {
    Box bounds;        ///< in the caller's coordinates
    double scale = 1;  ///< caller's units per unit of the frame

    static UnitFrame of(const Box& bounds) { return {bounds, std::max(bounds.width(), bounds.height())}; }

    /// Returns the largest absolute value of the caller's coordinates.
    double magnitude() const {
        return std::max(
            {std::abs(bounds.min.x), std::abs(bounds.min.y), std::abs(bounds.max.x), std::abs(bounds.max.y)});
    }

    /// Returns the size of the box in the unit frame.
    Point unit_size() const { return {bounds.width() / scale, bounds.height() / scale}; }

    Point to_user(Point unit) const { return bounds.min + scale * unit; }

    /// Returns the largest distance in the unit frame by which rounding in to_user() moves a point.
    double resolution() const {
        // Roundings of corners on input, and of products and sums on output, with a margin.
        constexpr double kRoundings = 16;
        return kRoundings * std::numeric_limits<double>::epsilon() * magnitude() / scale;
    }
};

}  // namespace ccdt
