// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/graph_solver.h"

#include <algorithm>
#include <numeric>

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// Conductance of a coarse edge, relative to the total conductance of the fine edges that it replaces. The potential
/// falls evenly over the width of an aggregate, which is two or three fine edges. In the coarse graph, all of this
/// difference lies across one edge, so the edge must conduct less.
constexpr double kLengthening = 0.35;

constexpr std::uint32_t kBlock = 512;  ///< vertices per block
/// Vertices per task. A task interleaves its blocks, because each step within a block waits for the previous step.
constexpr std::uint32_t kTask = 2048;

}  // namespace

GraphSolver::GraphSolver(std::size_t vertices, std::span<const Edge> edges, Executor& executor)
    : executor_(executor), sums_((vertices + kTask - 1) / kTask), direction_(vertices), image_(vertices) {
    std::vector<Edge> between;
    levels_.push_back(make_level(vertices, edges));
    for (;;) {
        Level& fine = levels_.back();
        const std::size_t count = aggregate(fine);
        if (count == fine.size()) break;
        list_members(fine, count);
        between.clear();
        for (std::uint32_t v = 0; v < fine.size(); ++v) {
            for (const Link& link : fine.links(v)) {
                const std::uint32_t a = fine.coarse[v], b = fine.coarse[link.to];
                if (a < b) between.push_back({a, b, kLengthening * link.conductance});
            }
        }
        levels_.push_back(make_level(count, between));
    }
    levels_.back().coarse.clear();
}

GraphSolver::Level GraphSolver::make_level(std::size_t vertices, std::span<const Edge> edges) {
    Level level;
    std::vector<std::uint32_t> first(vertices + 1, 0);
    for (const Edge& edge : edges) {
        ++first[edge.a + 1];
        ++first[edge.b + 1];
    }
    for (std::size_t v = 0; v < vertices; ++v) first[v + 1] += first[v];
    std::vector<std::uint32_t> end(first.begin(), first.end() - 1);
    std::vector<Link> links(2 * edges.size());
    for (const Edge& edge : edges) {
        links[end[edge.a]++] = {edge.b, static_cast<float>(edge.conductance)};
        links[end[edge.b]++] = {edge.a, static_cast<float>(edge.conductance)};
    }
    // Merges parallel links of a vertex into one.
    level.first.reserve(vertices + 1);
    level.first.push_back(0);
    level.all.reserve(links.size());
    std::vector<std::uint32_t> last(vertices, kNone);  // [vertices] index of the newest link to each vertex
    for (std::uint32_t v = 0; v < vertices; ++v) {
        const std::size_t begin = level.all.size();
        double sum = 0;
        for (const Link& link : std::span(links).subspan(first[v], first[v + 1] - first[v])) {
            if (last[link.to] == kNone || last[link.to] < begin) {
                last[link.to] = static_cast<std::uint32_t>(level.all.size());
                level.all.push_back(link);
            } else {
                level.all[last[link.to]].conductance += link.conductance;
            }
        }
        // Sorts the links: to lower numbers in the block of v, to higher numbers in the block, to other blocks.
        const auto from = level.all.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto beyond =
            std::partition(from, level.all.end(), [v](const Link& link) { return link.to / kBlock == v / kBlock; });
        const auto later = std::partition(from, beyond, [v](const Link& link) { return link.to < v; });
        level.later.push_back(static_cast<std::uint32_t>(later - level.all.begin()));
        level.beyond.push_back(static_cast<std::uint32_t>(beyond - level.all.begin()));
        for (std::size_t k = begin; k < level.all.size(); ++k) sum += level.all[k].conductance;
        level.first.push_back(static_cast<std::uint32_t>(level.all.size()));
        level.sum.push_back(sum);
        level.inverse.push_back(sum > 0 ? 1 / sum : 0);
    }
    level.inflow.resize(vertices);
    level.potential.resize(vertices);
    level.remaining.resize(vertices);
    return level;
}

/// Divides the vertices into aggregates. If neither a vertex nor any of its neighbours is in an aggregate yet, the
/// vertex forms an aggregate with all its neighbours. Each remaining vertex joins the aggregate of a neighbour: the one
/// with the largest conductance.
/// @returns  number of aggregates
std::size_t GraphSolver::aggregate(Level& level) {
    std::vector<std::uint32_t> seeds(level.size(), kNone);
    std::uint32_t count = 0;
    for (std::uint32_t v = 0; v < level.size(); ++v) {
        const auto links = level.links(v);
        if (seeds[v] != kNone) continue;
        if (std::ranges::any_of(links, [&](const Link& link) { return seeds[link.to] != kNone; })) continue;
        seeds[v] = count;
        for (const Link& link : links) seeds[link.to] = count;
        ++count;
    }
    level.coarse = seeds;
    for (std::uint32_t v = 0; v < level.size(); ++v) {
        if (seeds[v] != kNone) continue;
        double most = 0;
        for (const Link& link : level.links(v)) {
            if (seeds[link.to] == kNone || link.conductance <= most) continue;
            most = link.conductance;
            level.coarse[v] = seeds[link.to];
        }
    }
    return count;
}

void GraphSolver::list_members(Level& level, std::size_t count) {
    level.first_member.assign(count + 1, 0);
    for (const std::uint32_t coarse : level.coarse) ++level.first_member[coarse + 1];
    for (std::size_t i = 0; i < count; ++i) level.first_member[i + 1] += level.first_member[i];
    std::vector<std::uint32_t> end(level.first_member.begin(), level.first_member.end() - 1);
    level.members.resize(level.size());
    for (std::uint32_t v = 0; v < level.size(); ++v) level.members[end[level.coarse[v]]++] = v;
}

inline double GraphSolver::Level::outflow(std::uint32_t v, std::span<const double> potentials) const {
    double flow = sum[v] * potentials[v];
    for (const Link& link : links(v)) flow -= link.conductance * potentials[link.to];
    return flow;
}

/// Calls function(begin, end) for ranges of the vertices of a level, in parallel. A range is the work of one task.
/// @param vertices  number of vertices of the level
template <class Function>
void GraphSolver::for_blocks(std::size_t vertices, Function&& function) const {
    for_ranges(executor_, vertices, kTask, [&](std::size_t begin, std::size_t end) {
        function(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end));
    });
}

/// Calls function(begin, end) for ranges of the vertices of the finest level, in parallel.
/// @returns  the sum of the results
template <class Function>
double GraphSolver::sum_over_blocks(Function&& function) {
    for_blocks(size(), [&](std::uint32_t begin, std::uint32_t end) { sums_[begin / kTask] = function(begin, end); });
    return std::accumulate(sums_.begin(), sums_.end(), 0.0);
}

/// Approximates the potentials for a level's inflow by three steps: a relaxation sweep, a correction by the next level,
/// and a sweep in reverse order. The reverse order makes the operator symmetric.
void GraphSolver::cycle(std::size_t number) {
    Level& level = levels_[number];
    if (level.coarse.empty()) {  // the level has no links
        std::ranges::fill(level.potential, 0.0);
        return;
    }
    const auto flow = [&](std::uint32_t begin, std::uint32_t end) {
        double sum = 0;
        for (const Link& link : level.between(begin, end)) sum += link.conductance * level.potential[link.to];
        return sum;
    };
    const auto relax = [&](std::uint32_t v, double all) { level.potential[v] = all * level.inverse[v]; };
    // All potentials start at zero, so links to later vertices and to other blocks contribute nothing in this sweep.
    // What they would contribute after the sweep is the residual.
    for_blocks(level.size(), [&](std::uint32_t begin, std::uint32_t end) {
        const std::uint32_t most = std::min(kBlock, end - begin);
        for (std::uint32_t i = 0; i < most; ++i) {
            for (std::uint32_t v = begin + i; v < end; v += kBlock)
                relax(v, level.inflow[v] + flow(level.first[v], level.later[v]));
        }
    });
    for_blocks(level.size(), [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t v = begin; v < end; ++v) level.remaining[v] = flow(level.later[v], level.first[v + 1]);
    });
    Level& next = levels_[number + 1];
    for_blocks(next.size(), [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t v = begin; v < end; ++v) {
            next.inflow[v] = 0;
            for (std::uint32_t k = level.first_member[v]; k < level.first_member[v + 1]; ++k)
                next.inflow[v] += level.remaining[level.members[k]];
        }
    });
    cycle(number + 1);
    for_blocks(level.size(), [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t v = begin; v < end; ++v) level.potential[v] += next.potential[level.coarse[v]];
    });
    for_blocks(level.size(), [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t v = begin; v < end; ++v)
            level.remaining[v] = level.inflow[v] + flow(level.beyond[v], level.first[v + 1]);
    });
    for_blocks(level.size(), [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = std::min(kBlock, end - begin); i-- > 0;) {
            for (std::uint32_t v = begin + i; v < end; v += kBlock)
                relax(v, level.remaining[v] + flow(level.first[v], level.beyond[v]));
        }
    });
}

void GraphSolver::solve(std::span<double> inflow, std::span<double> potential, int steps) {
    constexpr double kNegligible = 1e-24;  // a residual below this consists of rounding errors
    Level& finest = levels_.front();
    std::ranges::fill(potential, 0.0);
    std::ranges::fill(direction_, 0.0);
    double first = 0, last = 0;
    for (int step = 0; step < steps; ++step) {
        std::ranges::copy(inflow, finest.inflow.begin());
        cycle(0);
        const double now = sum_over_blocks([&](std::uint32_t begin, std::uint32_t end) {
            double sum = 0;
            for (std::uint32_t v = begin; v < end; ++v) sum += inflow[v] * finest.potential[v];
            return sum;
        });
        if (step == 0) first = now;
        if (!(now > kNegligible * first)) return;
        const double kept = last > 0 ? now / last : 0;
        last = now;
        for_blocks(size(), [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t v = begin; v < end; ++v) direction_[v] = finest.potential[v] + kept * direction_[v];
        });
        const double energy = sum_over_blocks([&](std::uint32_t begin, std::uint32_t end) {
            double sum = 0;
            for (std::uint32_t v = begin; v < end; ++v)
                sum += direction_[v] * (image_[v] = finest.outflow(v, direction_));
            return sum;
        });
        if (!(energy > 0)) return;
        const double length = now / energy;
        for_blocks(size(), [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t v = begin; v < end; ++v) {
                potential[v] += length * direction_[v];
                inflow[v] -= length * image_[v];
            }
        });
    }
}

}  // namespace ccdt
