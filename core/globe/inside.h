#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// Tells what lies inside rings that do not cross, and takes there what lies just outside.
class Inside {
public:
    /// @param rings  the inside on their left
    explicit Inside(const std::vector<Ring>& rings);

    /// O(edges above and below).
    bool contains(Point p) const;

    /// The nearest place inside, by a nudge of 1e-12 to 1e-3 of the rings' extent that is as small as does; p itself
    /// if it is inside already, or if no nudge does. O(edges) for points outside.
    /// @param stretch  of distances along x over those along y
    Point nearest(Point p, double stretch) const;

private:
    struct Edge {
        Point a, b;
    };

    std::size_t column_of(double x) const;

    std::vector<Edge> edges_;
    std::vector<std::size_t> first_;  ///< of each column's edges in `members_` [columns + 1]
    std::vector<std::uint32_t> members_;
    double west_ = 0, column_width_ = 1, extent_ = 0;
};

}  // namespace ccdt
