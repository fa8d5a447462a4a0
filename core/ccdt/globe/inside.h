// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// Tests whether points lie inside rings that do not cross. Moves points that are just outside to the inside.
class Inside {
public:
    /// @param rings  with the inside on their left
    explicit Inside(const std::vector<Ring>& rings);

    /// Whether a point lies inside. O(edges in the point's column): a few, if edges are spread evenly.
    bool contains(Point p) const;

    /// Returns p if it is inside. Otherwise returns the nearest point of the rings, moved inwards as little as
    /// possible: by 1e-12 to 1e-3 of the rings' extent. If this does not suffice, returns p. O(edges).
    /// @param stretch  scale of distances along x relative to distances along y
    Point nearest(Point p, double stretch) const;

private:
    struct Edge {
        Point a, b;
    };

    std::size_t column_of(double x) const;

    std::vector<Edge> edges_;
    std::vector<std::size_t> first_;  ///< [columns + 1] where the edges of each column begin in `members_`
    std::vector<std::uint32_t> members_;
    double west_ = 0, column_width_ = 1, extent_ = 0;
};

}  // namespace ccdt
