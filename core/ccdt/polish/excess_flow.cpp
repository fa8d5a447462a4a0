// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/excess_flow.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kUnknown = ~std::uint32_t{0};

/// Numbers the connected components and returns the number of each vertex's component [vertices].
std::vector<std::uint32_t> connected_parts(const GraphSolver& graph) {
    std::vector<std::uint32_t> part_of(graph.size(), kUnknown), reached;
    std::uint32_t parts = 0;
    for (std::uint32_t v = 0; v < part_of.size(); ++v) {
        if (part_of[v] != kUnknown) continue;
        part_of[v] = parts;
        reached.push_back(v);
        while (!reached.empty()) {
            const std::uint32_t from = reached.back();
            reached.pop_back();
            for (const GraphSolver::Link& link : graph.links(from)) {
                if (part_of[link.to] != kUnknown) continue;
                part_of[link.to] = parts;
                reached.push_back(link.to);
            }
        }
        ++parts;
    }
    return part_of;
}

}  // namespace

ExcessFlow::ExcessFlow(std::size_t sites, std::span<const GraphSolver::Edge> edges, Executor& executor)
    : executor_(executor),
      solver_(sites, edges, executor),
      error_(sites),
      potential_(sites),
      part_of_(connected_parts(solver_)),
      sums_(part_of_.empty() ? 0 : *std::ranges::max_element(part_of_) + 1),
      counts_(sums_.size()) {}

bool ExcessFlow::solve(const std::stop_token& stop) {
    // Limit on the error of a site. In a narrow tongue, a single missing site is most of the density, so the error is
    // too large for a solution to first order. With a third of this limit, waves of four spacings in Canada are 5 dB
    // stronger.
    constexpr double kMax = 0.3;
    constexpr int kSteps = 2;  // benchmark CountryPattern: twice as many steps gain a decibel where there are fjords
    std::ranges::fill(sums_, 0.0);
    std::ranges::fill(counts_, 0.0);
    for (std::size_t v = 0; v < error_.size(); ++v) {
        error_[v] = std::clamp(error_[v], -kMax, kMax);
        sums_[part_of_[v]] += error_[v];
        counts_[part_of_[v]] += 1;
    }
    for (std::size_t v = 0; v < error_.size(); ++v) error_[v] = sums_[part_of_[v]] / counts_[part_of_[v]] - error_[v];
    if (stop.stop_requested()) return false;
    solver_.solve(error_, potential_, kSteps);
    return !stop.stop_requested();
}

}  // namespace ccdt
