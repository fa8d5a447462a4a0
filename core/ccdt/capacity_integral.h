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

/// What exact passes need of a triangle.
struct TriangleFlows {
    double capacity = 0;
    /// For each of its half-edges what it sweeps when its near end moves to its right, over the length of the move and
    /// its own: the density's integral over it, weighing 1 at the near end and 0 at the far one.
    std::array<double, 3> swept{};
};

/// Integrates a density over triangles of a domain, exactly: it is constant on its cells, so by Green's theorem a
/// triangle's capacity is the integral of F dy along its edges, F(x, y) the density's sum in the row up to x, and F
/// is linear within a cell. Capacities of all triangles add up to the domain's to rounding. Around a torus the density
/// repeats itself, and F grows by the row's total with every period.
class CapacityIntegral {
public:
    /// @param domain, density  must outlive this
    /// @param by_four          follows four edges at once if the processor can, which gives the same
    CapacityIntegral(const Domain& domain, const Density& density, bool by_four = true);

    bool is_uniform() const { return density_.is_uniform(); }

    /// Capacity of the whole domain; in units of the unit frame's area if uniform, else of one cell with density 1.
    /// Exactly 0 if it cannot be told from 0: below 1e-12 of the density's own.
    double total() const { return total_; }

    /// Capacity of each triangle [triangles]. O(half-edges), and their length in cells.
    /// @param stop  asked now and then; leaves capacities of no use
    void of_triangles(const Triangulation& mesh, std::vector<double>& capacities,
                      const std::stop_token& stop = {}) const;

    /// Capacity of each triangle and what its edges sweep [triangles]. Not for uniform densities. O(half-edges), and
    /// their length in cells.
    /// @param stop  asked now and then; leaves flows of no use
    void of_edges(const Triangulation& mesh, std::vector<TriangleFlows>& flows, const std::stop_token& stop = {}) const;

    /// Density at a point, in units of capacity per area of the unit frame; of one far outside that of the nearest
    /// cell.
    double at(Point p) const;

    /// Largest capacity per area of the unit frame.
    double densest() const { return is_uniform() ? 1 : density_.largest() * to_grid_.x * to_grid_.y; }

    /// Contribution of a segment to the capacity on its left: the integral of F dy from a to b, within the domain's
    /// bounding box. Not for uniform densities. O(cells crossed).
    double along(Point a, Point b) const;

    /// Number of cells that a segment crosses, about; at least 1, and 1 if uniform.
    int cells_along(Point a, Point b) const;

private:
    struct Segment {
        Point a, b;
    };

    /// Integrals along a segment.
    struct Sweep {
        double flow = 0;  ///< of F dy
        double near = 0;  ///< of the density per unit frame's area, over the segment, weighing 1 at a and 0 at b
        double far = 0;   ///< the other way round
    };
    template <bool kRepeated, class Lanes>
    void sweep_by(std::span<const Segment> segments, std::span<Sweep> sweeps) const;
    template <bool kRepeated>
    void sweep_by_four(std::span<const Segment> segments, std::span<Sweep> sweeps) const;
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
    std::vector<double> rows_below_;  ///< on a torus: total of the rows below each [height + 1]
};

}  // namespace ccdt
