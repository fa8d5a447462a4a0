// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/executor.h"

namespace ccdt {

/// Solves Laplace's equation on a graph whose edges have conductances: finds the potentials that drive given inflows
/// through the edges. Uses conjugate gradients with a multigrid preconditioner. Each vertex of a coarser graph replaces
/// an aggregate, that is, a vertex and its neighbours. The graph need not be connected. The relaxation (Gauss-Seidel)
/// processes blocks of successive vertices in parallel. A block uses the potentials of other blocks from before the
/// sweep.
///
/// Source: Vanek, Mandel, Brezina, Algebraic multigrid by smoothed aggregation, Computing 56 (1996), for the choice of
/// aggregates. Departure: prolongation is not smoothed; instead, corrections are scaled up.
class GraphSolver {
public:
    struct Edge {
        std::uint32_t a, b;  ///< two different vertices
        double conductance;  ///< > 0
    };
    struct Link {
        std::uint32_t to;
        float conductance;
    };

    /// @param edges     the conductances of parallel edges are added; most neighbours should have close numbers, so
    ///                  that they are in the same block
    /// @param executor  runs the tasks; must outlive this object
    ///
    /// O(vertices + edges).
    GraphSolver(std::size_t vertices, std::span<const Edge> edges, Executor& executor = inline_executor());

    std::size_t size() const { return levels_.front().size(); }

    /// Returns the links of a vertex, one to each neighbour.
    std::span<const Link> links(std::uint32_t vertex) const { return levels_.front().links(vertex); }

    /// Finds potentials such that, at each vertex, the sum of conductance * (potential - neighbour's potential) over
    /// its links is approximately the inflow.
    /// @param inflow     [vertices], with sum 0 in each connected component; overwritten
    /// @param potential  out [vertices]
    /// @param steps      number of iterations, each of which reduces the error to a third or less
    ///
    /// O(vertices + edges) per step.
    void solve(std::span<double> inflow, std::span<double> potential, int steps);

private:
    struct Level {
        /// [vertices + 1] start of each vertex' links. First come the links to lower numbers in the vertex' block, then
        /// the links to higher numbers in the block, then the links to other blocks.
        std::vector<std::uint32_t> first;
        /// [vertices] start of the vertex' links to higher numbers in its block.
        std::vector<std::uint32_t> later;
        std::vector<std::uint32_t> beyond;  ///< [vertices] start of the vertex' links to other blocks
        std::vector<Link> all;              ///< links of all vertices
        std::vector<double> sum;            ///< [vertices] sum of the links' conductances
        std::vector<double> inverse;        ///< [vertices] 1 / sum, or 0
        std::vector<std::uint32_t> coarse;  ///< [vertices] vertex of the next level that replaces it; empty on the last
        /// Lists of the vertices that each vertex of the next level replaces. `members` contains all lists [vertices],
        /// and `first_member` the start of each list [vertices of the next level + 1].
        std::vector<std::uint32_t> members, first_member;
        /// [vertices] State of cycle(). `remaining` is first the residual, then the inflow including flows from other
        /// blocks.
        std::vector<double> inflow, potential, remaining;

        std::size_t size() const { return sum.size(); }
        std::span<const Link> links(std::uint32_t v) const { return between(first[v], first[v + 1]); }
        std::span<const Link> between(std::uint32_t begin, std::uint32_t end) const {
            return {all.data() + begin, all.data() + end};
        }
        double outflow(std::uint32_t v, std::span<const double> potentials) const;
    };

    static Level make_level(std::size_t vertices, std::span<const Edge> edges);
    static std::size_t aggregate(Level& level);
    static void list_members(Level& level, std::size_t count);
    template <class Function>
    void for_blocks(std::size_t vertices, Function&& function) const;
    template <class Function>
    double sum_over_blocks(Function&& function);
    void cycle(std::size_t number);

    Executor& executor_;
    std::vector<double> sums_;  ///< [tasks] partial sums
    std::vector<Level> levels_;
    std::vector<double> direction_, image_;  ///< [vertices] search direction, and the outflows that it causes
};

}  // namespace ccdt
