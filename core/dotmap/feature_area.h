#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Tells what lies inside a domain that is no torus, in the caller's coordinates: strictly, and farther from the border
/// than rounding reaches.
class FeatureArea {
public:
    explicit FeatureArea(const Domain& domain);

    const Box& bounds() const { return bounds_; }

    /// O(edges in the row of the point), which are few but where borders are scribbled.
    bool contains(Point p) const;

    /// Where one gets who goes from one place towards another and must not leave: there, if that is inside; else along
    /// the border that is in the way, as far, or half the way to it, or nowhere.
    /// @param from  inside
    Point towards(Point from, Point to) const;

private:
    struct Edge {
        Point low, high;  ///< low.y <= high.y
    };

    std::size_t row_of(double y) const;
    const Edge* first_crossed(Point from, Point to, double& at) const;

    Box bounds_;
    double margin_ = 0;
    double row_height_ = 1;
    std::vector<std::size_t> first_;  ///< of each row's edges [rows + 1]
    std::vector<Edge> edges_;         ///< by rows; those that reach into several are in each of these
};

}  // namespace ccdt
