// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Data of a triangle for exact passes.
struct TriangleFlows {
    double capacity = 0;
    /// For each half-edge: integral of (1 - t) * density, where t runs from 0 at the origin to 1 at the target. The
    /// integral times the edge's length is the capacity swept by the edge, per unit by which its origin moves to the
    /// right.
    std::array<double, 3> swept{};
};

/// Integrates a density exactly over the triangles of a domain. The density is constant on cells, so by Green's theorem
/// a triangle's capacity is the integral of F dy along its edges. F(x, y) is the integral of the density in the grid
/// row of y, from the left side of the box to x. F is linear within a cell. The capacities of all triangles add up to
/// the capacity of the domain, except for rounding. On a torus the density is periodic, and F grows by the row's total
/// with each period.
class CapacityIntegral {
public:
    /// @param domain, density  must outlive this
    /// @param by_four          whether to process four edges at once if possible; the results are the same either way
    CapacityIntegral(const Domain& domain, const Density& density, bool by_four = true);

    bool is_uniform() const { return density_.is_uniform(); }

    /// Returns the capacity of the whole domain. For a uniform density, this is the area in the unit frame; else the
    /// unit is one cell of density 1. A capacity below 1e-12 of the density's total may be a rounding error, and is
    /// returned as 0.
    double total() const { return total_; }

    /// Computes the capacity of each triangle [triangles]. O(half-edges + cells crossed).
    /// @param stop  polled regularly; after a stop the capacities must not be used
    void of_triangles(const Triangulation& mesh, std::vector<double>& capacities,
                      const std::stop_token& stop = {}) const;

    /// Computes the capacity of each triangle and the integrals along its edges [triangles]. Not for uniform densities.
    /// O(half-edges + cells crossed).
    /// @param stop  polled regularly; after a stop the flows must not be used
    void of_edges(const Triangulation& mesh, std::vector<TriangleFlows>& flows, const std::stop_token& stop = {}) const;

    /// Returns the density at a point or, outside the box, at the nearest cell; in capacity per area of the unit frame.
    double at(Point p) const;

    /// Returns the largest capacity per area of the unit frame.
    double densest() const { return is_uniform() ? 1 : density_.largest() * to_grid_.x * to_grid_.y; }

    /// Returns the contribution of a segment to the capacity on its left: the integral of F dy from a to b, which lie
    /// within the domain's bounding box. Not for uniform densities. O(cells crossed).
    double along(Point a, Point b) const;

    /// Returns the approximate number of cells that a segment crosses, at least 1. If the density is uniform, 1.
    int cells_along(Point a, Point b) const;

private:
    struct Segment {
        Point a, b;
    };

    /// Integrals along a segment.
    struct Sweep {
        double flow = 0;  ///< integral of F dy
        /// Integral of (1 - t) * density, where t runs from 0 at a to 1 at b; in capacity per area of the unit frame.
        double near = 0;
        double far = 0;  ///< integral of t * density
    };
    template <bool kRepeated, class Lanes>
    void sweep_by(std::span<const Segment> segments, std::span<Sweep> sweeps) const;
    template <bool kRepeated>
    void sweep(std::span<const Segment> segments, std::span<Sweep> sweeps) const;
    double rows_below(double y) const;
    template <class Add>
    void add_flow(const Triangulation& mesh, std::uint32_t edge, double flow, bool repeated, Add&& add) const;
    template <class Capacity, class Take>
    void sum_flows(const Triangulation& mesh, const std::stop_token& stop, Capacity&& capacity, Take&& take) const;
    Point to_grid(Point p) const { return {p.x * to_grid_.x, p.y * to_grid_.y}; }

    const Density& density_;
    bool by_four_;
    Point to_grid_{1, 1};  ///< cells per unit
    double total_ = 0;
    std::vector<double> rows_below_;  ///< on a torus: total of all rows below each row [height + 1]
};

}  // namespace ccdt
