// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/polish/graph_solver.h"
#include "core/ccdt/polish/push.h"

namespace ccdt {

/// Computes moves of sites that cancel a small error of their density: the excess flows along the edges of a graph, and
/// the sites follow. README.md has the derivation.
class ExcessFlow {
public:
    /// @param edges     edges between sites, with their conductances: edges_between_sites()
    /// @param executor  must outlive this object
    ExcessFlow(std::size_t sites, std::span<const GraphSolver::Edge> edges, Executor& executor);

    /// Returns the errors of the sites. An error is the excess of sites around a site, in sites. The caller writes them
    /// before solve().
    std::span<double> errors() { return error_; }

    /// Finds the potentials that drive the excess away. Limits the errors and subtracts the mean error of each
    /// connected component, because the measure of the errors smooths across gaps in the domain. Overwrites the errors.
    /// @returns  false after a stop; moves() must not be called then
    bool solve(const std::stop_token& stop);

    /// Converts flows along edges to moves: each end of an edge moves by half the flow times the edge vector.
    /// @param toward    returns the vector from one site to another
    /// @param spacings  [sites] 1 / sqrt(wanted density of sites)
    /// @param moves     out [sites], each at most 0.35 of the local spacing
    template <class Toward, class Position>
    void moves(Toward&& toward, std::span<const double> spacings, std::span<Position> moves) const {
        constexpr double kMaxMove = 0.35;  // in spacings; 0.25: 1 dB more noise in fjords (benchmark CountryPattern)
        constexpr std::size_t kSites = 4096;
        for_ranges(executor_, potential_.size(), kSites, [&](std::size_t begin, std::size_t end) {
            for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
                Position move;
                for (const auto& [to, conductance] : solver_.links(v)) {
                    const double flow = conductance * (potential_[to] - potential_[v]);
                    move = move + (flow / 2) * toward(v, to);
                }
                moves[v] = capped(move, kMaxMove * spacings[v]);
            }
        });
    }

private:
    Executor& executor_;
    GraphSolver solver_;
    std::vector<double> error_, potential_;  ///< [sites] error and potential of each site
    /// [sites] number of the site's component. Sites are connected if a path of edges that carry a flow joins them.
    std::vector<std::uint32_t> part_of_;
    std::vector<double> sums_;    ///< [components] sum of the errors of the sites
    std::vector<double> counts_;  ///< [components] number of sites
};

}  // namespace ccdt
