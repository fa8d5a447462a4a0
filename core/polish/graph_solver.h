#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel/team.h"

namespace ccdt {

/// Solves Laplace's equation on a graph whose edges have conductances: finds potentials whose differences drive through
/// the edges what flows into the vertices and out again. Conjugate gradients, preconditioned by a multigrid cycle whose
/// coarser graphs have one vertex for each of some vertices and their neighbours. A graph may consist of several parts
/// that nothing links. Vertices are relaxed in blocks of successive numbers at the same time, each by what the others'
/// potentials were before.
///
/// Source: Vanek, Mandel, Brezina, Algebraic multigrid by smoothed aggregation, Computing 56 (1996), for the choice of
/// aggregates. Departs from it in that prolongation is not smoothed; corrections are lengthened instead.
class GraphSolver {
public:
    struct Edge {
        std::uint32_t a, b;  ///< vertices, not the same
        double conductance;  ///< > 0
    };
    struct Link {
        std::uint32_t to;
        float conductance;
    };

    /// @param edges  those between the same vertices add up; of neighbours numbers should be near each other
    /// @param team   does the work; must outlive this
    /// O(vertices + edges).
    GraphSolver(std::size_t vertices, std::span<const Edge> edges, Team& team = alone());

    std::size_t size() const { return levels_.front().size(); }

    /// Edges of a vertex.
    std::span<const Link> links(std::uint32_t vertex) const { return levels_.front().links(vertex); }

    /// Finds potentials so that sum of conductance * (potential - neighbour's) = inflow, as near as so many steps get.
    /// @param inflow     [vertices], its sum 0 in each part that hangs together; used up
    /// @param potential  out [vertices]
    /// O(vertices + edges) a step, which takes off the error two thirds or more.
    void solve(std::span<double> inflow, std::span<double> potential, int steps);

private:
    struct Level {
        std::vector<std::uint32_t>
            first;  ///< [vertices + 1] of its links: those within its block in order, then others
        std::vector<std::uint32_t> later;   ///< [vertices] of these the first to a vertex with a larger number
        std::vector<std::uint32_t> beyond;  ///< [vertices] of these the first that leaves the block
        std::vector<Link> all;              ///< of all vertices
        std::vector<double> sum;            ///< [vertices] of the links' conductances
        std::vector<double> inverse;        ///< [vertices] 1 over that, or 0
        std::vector<std::uint32_t> coarse;  ///< [vertices] vertex of the next level; empty on the last one
        std::vector<std::uint32_t> members, first_member;  ///< of each vertex of the next level [vertices of it + 1]
        std::vector<double> inflow, potential, left;

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

    Team& team_;
    std::vector<double> sums_;  ///< [blocks]
    std::vector<Level> levels_;
    std::vector<double> direction_, image_;  ///< [vertices]
};

}  // namespace ccdt
