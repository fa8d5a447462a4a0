#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Tells what lies inside a domain that is no torus, in the caller's coordinates: strictly, and farther from the border
/// than rounding reaches.
class FeatureArea {
public:
    /// Where a point is.
    enum class Place {
        Outside,
        Margin,  ///< inside, but nearer to an edge than it should be
        Inside,
    };

    /// Distance that points should keep from an edge.
    /// @param inwards  normal of the edge, of length 1
    using Clearance = std::function<double(Point middle, Point inwards)>;

    /// @param clearance  none: 0
    explicit FeatureArea(const Domain& domain, const Clearance& clearance = {});

    const Box& bounds() const { return bounds_; }

    /// O(edges in the row of the point), which are few but where borders are scribbled.
    bool contains(Point p) const { return place_of(p) != Place::Outside; }
    Place place_of(Point p) const {
        const Edge* edge = nullptr;
        return place_of(p, edge);
    }

    /// Where one gets who goes from one place towards another and must not leave: there, if that is inside; else along
    /// the border that is in the way, as far, or half the way to it, or nowhere. Who keeps clear of the border goes on
    /// doing so.
    /// @param from  not outside
    Point towards(Point from, Point to) const;

private:
    struct Edge {
        Point low, high;  ///< low.y <= high.y
        double clearance;
        double length;
    };

    std::size_t row_of(double y) const;
    Place place_of(Point p, const Edge*& near) const;
    const Edge* first_crossed(Point from, Point to, double& at) const;

    Box bounds_;
    double margin_ = 0;
    double row_height_ = 1;
    std::vector<std::size_t> first_;  ///< of each row's edges [rows + 1]
    std::vector<Edge> edges_;         ///< by rows; those that reach into several are in each of these
};

}  // namespace ccdt
