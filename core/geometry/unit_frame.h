#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/point.h"

namespace ccdt {

/// The frame in which the longer side of a box is 1 and its lower left corner the origin.
struct UnitFrame {
    Box bounds;        ///< in the caller's coordinates
    double scale = 1;  ///< caller's units per unit

    static UnitFrame of(const Box& bounds) { return {bounds, std::max(bounds.width(), bounds.height())}; }

    /// Largest absolute value of the caller's coordinates.
    double magnitude() const {
        return std::max(
            {std::abs(bounds.min.x), std::abs(bounds.min.y), std::abs(bounds.max.x), std::abs(bounds.max.y)});
    }

    /// Of the box, in the unit frame.
    Point unit_size() const { return {bounds.width() / scale, bounds.height() / scale}; }

    Point to_user(Point unit) const { return bounds.min + scale * unit; }

    /// Distance by which to_user() may move a point by rounding, in the unit frame.
    double resolution() const {
        constexpr double kRoundings = 16;  // of corners on their way in, of products and sums on the way out, with room
        return kRoundings * std::numeric_limits<double>::epsilon() * magnitude() / scale;
    }
};

}  // namespace ccdt
