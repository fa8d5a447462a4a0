// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/ccdt/polish/cell_list.h"
#include "core/geometry/axes.h"
#include "core/points/order/point_box.h"

namespace ccdt::ordering {

/// Number of neighbours whose distance measures the local density. It is large enough for a stable measure, and small
/// enough for the neighbours to be near.
inline constexpr std::size_t kNeighbours = 12;

/// Measures the local spacing of points, the side of the square or cube that holds one point, by the distance of their
/// nearest neighbours.
template <class P>
class SpacingMeter {
public:
    /// @param usual  spacing of the same number of points at uniform density
    SpacingMeter(const PointBox<P>& frame, const Points<P>& points, const BasicCellList<P>& near, double usual)
        : frame_(frame), points_(points), near_(near), usual_(usual) {
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) widest_ += 2 * along(frame.sides, axis);
    }

    double operator()(std::uint32_t point) {
        const std::size_t wanted = std::min(kNeighbours, points_.size() - 1);
        double reach = 2.2 * usual_;  // slightly beyond the usual distance of this number of neighbours
        while (!find(point, reach, wanted) && reach < widest_) reach *= 2;
        if (squares_.size() < wanted || wanted == 0) return usual_;
        const auto last = squares_.begin() + static_cast<std::ptrdiff_t>(wanted) - 1;
        std::ranges::nth_element(squares_, last);
        // Coincident points have spacing 0, but the spacing must be usable as a divisor.
        constexpr double kMinShare = 1e-9;
        const double ball = std::numbers::pi * *last * (frame_.is_solid ? std::sqrt(*last) * 4 / 3 : 1);
        return std::max(frame_.side_of(ball / static_cast<double>(wanted)), kMinShare * usual_);
    }

private:
    /// Whether there are enough neighbours within reach.
    bool find(std::uint32_t point, double reach, std::size_t wanted) {
        squares_.clear();
        near_.for_near(points_.positions[point], reach, [&](P position, std::uint32_t number) {
            const P apart = position - points_.positions[point];
            const double square = dot(apart, apart);
            if (number == point || square >= reach * reach || points_.are_opposed(point, number)) return;
            squares_.push_back(square);
        });
        return squares_.size() >= wanted;
    }

    const PointBox<P>& frame_;
    const Points<P>& points_;
    const BasicCellList<P>& near_;
    double usual_;
    double widest_ = 0;  ///< reach at which all points are found
    std::vector<double> squares_;
};

}  // namespace ccdt::ordering
