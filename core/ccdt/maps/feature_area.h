// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Tests whether points lie inside a domain that is not a torus, in the caller's coordinates. Points that pass the test
/// lie inside by more than rounding errors.
class FeatureArea {
public:
    /// Position of a point relative to the area.
    enum class Position {
        Outside,
        Margin,  ///< inside, but nearer to an edge than the edge's clearance
        Inside,
    };

    /// Returns the distance that points should keep from an edge.
    /// @param middle   middle of the edge
    /// @param inwards  unit normal of the edge, pointing inwards
    using Clearance = std::function<double(Point middle, Point inwards)>;

    /// Creates an empty area.
    FeatureArea() = default;

    /// @param clearance  none: all clearances are 0
    /// @param cells      approximate number of cells of a grid that stores which cells lie entirely inside; 0: no grid
    explicit FeatureArea(const Domain& domain, const Clearance& clearance = {}, std::size_t cells = 0);

    const Box& bounds() const { return bounds_; }

    /// Whether a point lies inside. O(1) in cells that lie entirely inside; else O(edges in the point's row), which are
    /// few for common shapes.
    bool contains(Point p) const { return position_of(p) != Position::Outside; }
    Position position_of(Point p) const {
        const Edge* edge = nullptr;
        return position_of(p, edge);
    }
    /// Whether a point lies in a cell that is entirely inside. O(1).
    bool is_far_inside(Point p) const {
        return !grid_.empty() && grid_[grid_row(p.y) * grid_columns_ + grid_column(p.x)] == Cell::Inside;
    }

    /// Moves a point from one position towards another, without leaving the area. Returns the end of the move. If `to`
    /// is inside, the move ends there. Otherwise the point slides along the obstructing edge. If sliding would leave
    /// the area, too, the point moves half of the way to the edge, or not at all. Points that keep the clearance
    /// continue to do so.
    /// @param from  not outside
    Point towards(Point from, Point to) const;

private:
    struct Edge {
        Point low, high;  ///< low.y <= high.y
        double clearance;
        double length;
    };

    /// Near: within the clearance of an edge; Inside: farther than the clearance from all edges.
    enum class Cell : std::uint8_t { Outside, Near, Inside };

    std::size_t row_of(double y) const;
    std::size_t grid_row(double y) const { return index((y - bounds_.min.y) * rows_per_unit_, grid_rows_); }
    std::size_t grid_column(double x) const { return index((x - bounds_.min.x) * columns_per_unit_, grid_columns_); }
    static std::size_t index(double position, std::size_t cells) {
        return static_cast<std::size_t>(std::clamp(position, 0.0, static_cast<double>(cells - 1)));
    }
    void make_grid(const std::vector<Edge>& edges, double crossings, std::size_t cells);
    void mark(const Edge& edge);
    Position position_of(Point p, const Edge*& near) const;
    const Edge* first_crossed(Point from, Point to, double& at) const;

    Box bounds_;
    double margin_ = 0;
    double row_height_ = 1;
    std::vector<std::size_t> first_;  ///< [rows + 1] index in `edges_` of the first edge of each row
    std::vector<Edge> edges_;         ///< sorted by row; an edge is listed in every row that it reaches
    std::size_t grid_columns_ = 1, grid_rows_ = 1;
    double columns_per_unit_ = 1, rows_per_unit_ = 1;
    std::vector<Cell> grid_;  ///< [rows][columns], or empty
};

}  // namespace ccdt
