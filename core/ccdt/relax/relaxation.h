// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/relax/capacity_integral.h"
#include "core/ccdt/relax/move_groups.h"
#include "core/ccdt/relax/triangle_goals.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

// Defined in move_equations.h.
struct GoalTerm;
struct NormalEquations;
template <std::size_t kPairs, class Lanes>
struct LaneRings;
template <class Lanes>
struct LaneEquations;

/// Restricts the moves of sites. Returns `to` if the site may lie at `to`, else a position between the site and `to`.
using Fence = std::function<Point(std::uint32_t site, Point to)>;

// Stiffer springs and longer moves increase both the distance between neighbours and the error of tone: benchmarks
// TorusPattern and PictureTone.
inline constexpr double kSpring = 0.01;     ///< stiffness of edges relative to the stiffness of areas or volumes
inline constexpr double kRelaxation = 1.2;  ///< length of a move relative to the move to the minimum, in [1, 2)
/// Stiffness of edges if a polish follows, which then leaves the least power in long waves: benchmark TorusPattern.
inline constexpr double kPolishedSpring = 0.03;

struct RelaxationOptions {
    double spring = kSpring;
    /// Additional stiffness of border edges. Without it, more sites crowd along the border: benchmark BorderPattern.
    double border_spring = 0.1;
    double relaxation = kRelaxation;
    double least_height = 1e-9;  ///< least height of a triangle after a move, in the unit frame
    /// Doubled area below which a triangle is checked for being a needle. None: derived from the mean area of all
    /// triangles, which suits meshes with triangles of similar size.
    std::optional<double> small_area;
    std::optional<double> site_share;  ///< share of the capacity for each site; none: all shares are equal
    Fence fence;                       ///< applied to the moves of all sites; may be empty
    /// Whether to move two sites at once if the processor can; the results are the same either way.
    bool by_two = true;
};

/// Moves vertices, one at a time, to where the capacities of the triangles around them come closest to their targets.
/// This is coordinate descent on an energy. Each triangle contributes (weight * doubled area - target)^2 / share, and
/// each edge contributes spring * mean weight * share * length^2, with stiffer springs on border edges. So a fan of k
/// triangles, each with a share of 1/k, counts as much as the one triangle that it replaces.
///
/// Sites move freely, vertices on straight parts of the border slide along them, and corners are fixed. A move is
/// shortened if a triangle would lose more than 90 % of its area or become a needle. So all triangles stay
/// counter-clockwise after any number of passes.
///
/// Source: Xu et al. 2011, section 3.2, the 2 x 2 system R^T R X = -R^T S. Departures: targets are given, not the mean
/// of the one-ring; springs; over-relaxation.
class Relaxation {
public:
    /// @param fixed    [vertices - sites] for the border's vertices: whether the vertex never moves
    /// @param uniform  whether all weights are equal, and all triangles between three sites have the same target
    Relaxation(Triangulation& mesh, std::vector<bool> fixed, bool uniform, const RelaxationOptions& options);

    /// Lists the mesh's edges and stores new goals. Must be called before the first pass and after every
    /// restore_delaunay(). O(vertices).
    /// @param stop  polled regularly; no pass may follow a stop
    void prepare(TriangleGoals goals, const std::stop_token& stop = {});

    /// Stores new goals, and lists the data that exact passes need, which is less than for pass(). Must be called
    /// before the first exact pass and after every restore_delaunay(). O(vertices).
    void prepare_exact(TriangleGoals goals, const std::stop_token& stop = {});

    /// Returns the goals and releases the memory of measurements. New goals must be given before the next pass.
    TriangleGoals take_goals();

    /// Moves every vertex `times` times. The sites of a block move a few times in a row while their data is in the
    /// cache; then the sites between blocks move as often, and then the vertices of the border. O(vertices * times).
    /// @param stop  polled regularly; a stop leaves vertices where they are
    void pass(int times = 1, const std::stop_token& stop = {});

    /// Measures the capacities and the integrals along edges for exact passes. O(half-edges + cells crossed).
    /// @param stop  polled regularly; no exact pass may follow a stop
    void measure(const CapacityIntegral& capacity, const std::stop_token& stop = {});

    /// Moves every vertex, in the order of pass(), to where the true capacities come closest to their targets. pass()
    /// assumes that a triangle keeps its mean density as its corners move. An exact pass uses the density along the
    /// moving edges instead. Between calls of measure(), capacities are updated to first order.
    ///
    /// Unlike pass(), an exact pass does not stall next to areas of density zero or at other steep changes.
    /// O(vertices). Source: Gauss and Newton's method; Reynolds' transport theorem.
    void exact_pass(int times = 1, const std::stop_token& stop = {});

    /// Returns the energy that the passes minimise. No pass increases it.
    double energy() const;

private:
    using Fan = MoveGroups::Fan;
    using Fans = MoveGroups::Fans;
    using Group = MoveGroups::Group;
    template <class Lanes>
    using Records = MoveGroups::Records<Lanes>;

    /// A triangle (site, from, to) around a site in an exact pass.
    struct ExactTriangle {
        std::uint32_t triangle;
        std::uint32_t vertex;  ///< the vertex `from`
        Point from;            ///< relative to the site
        Point gradient;        ///< gradient of the triangle's capacity
    };

    /// Buffers for the one-ring of a site in an exact pass, counter-clockwise.
    struct ExactRing {
        std::vector<ExactTriangle> triangles;
        Fans fans;  ///< the site's fan, if the general path is taken
    };

    /// Neighbours of a vertex on the general path, counter-clockwise and cyclic.
    struct Ring {
        std::span<const std::uint32_t> vertices;
        const Point* lifts;  ///< shift of each neighbour around a torus; null if there are no shifts
    };
    Point position(const Ring& ring, std::size_t i) const;
    Ring ring_of(const Fans& fans, const Fan& fan) const;
    double mean_doubled_area() const;
    GoalTerm term(std::uint32_t triangle) const;
    template <class Move>
    void for_groups(int times, const std::stop_token& stop, Move&& move);
    void move_group(const Group& group);
    template <bool kPlain, std::size_t kPairs>
    void move_batch(const Group& group);
    template <std::size_t kPairs>
    static bool has_neighbour(const std::uint32_t* record, std::uint32_t site);
    template <std::size_t kPairs, class Lanes>
    LaneEquations<Lanes> plain_equations(const LaneRings<kPairs, Lanes>& rings, const Records<Lanes>& records) const;
    template <std::size_t kPairs, class Lanes>
    LaneEquations<Lanes> weighted_equations(const LaneRings<kPairs, Lanes>& rings, const Records<Lanes>& records) const;
    template <bool kPlain, std::size_t kPairs, class Lanes>
    void move_few(const Records<Lanes>& records);
    NormalEquations equations_of(const Fans& fans, const Fan& fan) const;
    void move_site(const Fans& fans, const Fan& fan);
    void move_group_exactly(std::size_t level, std::size_t number);
    double swept(std::uint32_t edge) const {
        return flows_[Triangulation::triangle_of(edge)].swept[Triangulation::number_of(edge)];
    }
    void move_exactly(std::uint32_t site, ExactRing& ring);
    bool surely_fits(std::uint32_t site, Point by, const ExactRing& ring) const;
    void slide(const Fans& fans, const Fan& fan);
    void move(std::uint32_t vertex, Point by, const Ring& ring, std::size_t triangles);
    Point fenced(std::uint32_t site, Point by) const {
        return options_.fence ? options_.fence(site, mesh_.point(site) + by) - mesh_.point(site) : by;
    }
    Point rounded(Point p) const { return {(p.x + magic_) - magic_, (p.y + magic_) - magic_}; }

    Triangulation& mesh_;
    RelaxationOptions options_;
    double magic_ = 0;         ///< rounds positions to multiples of 2^-50 on a torus; else 0
    double small_ = 0;         ///< doubled area below which the fast path leaves a triangle to the general path
    double plain_weight_ = 0;  ///< weight of the triangles around plain sites
    TriangleGoals goals_;
    MoveGroups groups_;
    std::vector<TriangleFlows> flows_;  ///< [triangles] current capacities; swept integrals as last measured
    double unit_ = 0;                   ///< factor that converts capacities to units of half a site's capacity
};

}  // namespace ccdt
