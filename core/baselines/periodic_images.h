// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// The periodic images of a point: its copies on a torus. In other domains, the point itself is the only image.
class PeriodicImages {
public:
    explicit PeriodicImages(const Domain& domain) {
        if (!domain.is_torus()) return;
        period_ = domain.unit_bounds().max;
        half_ = 0.5 * period_;
    }

    bool is_torus() const { return period_.x > 0; }

    /// Returns the distance between copies along each axis; {0, 0} if there are no copies.
    Point period() const { return period_; }

    /// Returns the shortest vector between copies of two points.
    /// @param way  vector between some copies of the points, shorter than one and a half periods along each axis
    Point shortest(Point way) const {
        return {shortest(way.x, period_.x, half_.x), shortest(way.y, period_.y, half_.y)};
    }

    /// Returns the copy in the box [0, period).
    Point in_box(Point p) const { return is_torus() ? wrapped(p, period_) : p; }

private:
    static double shortest(double way, double period, double half) {
        way -= way > half ? period : 0;
        return way + (way < -half ? period : 0);
    }

    Point period_{0, 0};
    Point half_{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

}  // namespace ccdt
