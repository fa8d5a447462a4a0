#pragma once

#include <algorithm>
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

    /// Nothing.
    FeatureArea() = default;

    /// @param clearance  none: 0
    /// @param cells      about how many a grid has that knows which of them lie inside as a whole; 0: there is none
    explicit FeatureArea(const Domain& domain, const Clearance& clearance = {}, std::size_t cells = 0);

    const Box& bounds() const { return bounds_; }

    /// O(1) in cells that lie inside; else O(edges in the row of the point), which are few but where borders are
    /// scribbled.
    bool contains(Point p) const { return place_of(p) != Place::Outside; }
    Place place_of(Point p) const {
        const Edge* edge = nullptr;
        return place_of(p, edge);
    }
    /// Tells whether a point lies in a cell that is all inside. O(1).
    bool is_deep(Point p) const {
        return !grid_.empty() && grid_[grid_row(p.y) * grid_columns_ + grid_column(p.x)] == Cell::Inside;
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

    enum class Cell : std::uint8_t { Outside, Near, Inside };  ///< near an edge; inside, and far enough from all edges

    std::size_t row_of(double y) const;
    std::size_t grid_row(double y) const { return index((y - bounds_.min.y) * rows_per_unit_, grid_rows_); }
    std::size_t grid_column(double x) const { return index((x - bounds_.min.x) * columns_per_unit_, grid_columns_); }
    static std::size_t index(double place, std::size_t cells) {
        return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(cells - 1)));
    }
    void make_grid(const std::vector<Edge>& edges, double crossings, std::size_t cells);
    void mark(const Edge& edge);
    Place place_of(Point p, const Edge*& near) const;
    const Edge* first_crossed(Point from, Point to, double& at) const;

    Box bounds_;
    double margin_ = 0;
    double row_height_ = 1;
    std::vector<std::size_t> first_;  ///< of each row's edges [rows + 1]
    std::vector<Edge> edges_;         ///< by rows; those that reach into several are in each of these
    std::size_t grid_columns_ = 1, grid_rows_ = 1;
    double columns_per_unit_ = 1, rows_per_unit_ = 1;
    std::vector<Cell> grid_;  ///< [rows][columns] or empty
};

}  // namespace ccdt
