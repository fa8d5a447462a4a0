// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Draws points uniformly from the inside of a triangulation.
class InteriorSampler {
public:
    /// @param triangles  counter-clockwise; at least one
    explicit InteriorSampler(std::vector<std::array<Point, 3>> triangles) : triangles_(std::move(triangles)) {
        double sum = 0;
        for (const auto& [a, b, c] : triangles_) areas_.push_back(sum += cross(b - a, c - a));
    }

    Point draw(Random& random) const {
        const double level = areas_.back() * random.uniform();
        const auto i = std::lower_bound(areas_.begin(), areas_.end(), level) - areas_.begin();
        const auto& [a, b, c] = triangles_[std::min(static_cast<std::size_t>(i), triangles_.size() - 1)];
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        return a + u * (b - a) + v * (c - a);
    }

private:
    std::vector<std::array<Point, 3>> triangles_;
    std::vector<double> areas_;  ///< doubled areas, cumulative
};

}  // namespace ccdt
