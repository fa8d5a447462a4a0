#include "core/polish/graph_solver.h"

#include <algorithm>

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// Conductance of the next level's edges over that of those they stand for, which are joined not only side by side:
/// where a potential falls evenly over two or three edges in line, as wide as an aggregate is, it falls at once over
/// one here.
constexpr double kLengthening = 0.35;

double product(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

}  // namespace

GraphSolver::GraphSolver(std::size_t vertices, std::span<const Edge> edges) : direction_(vertices), image_(vertices) {
    std::vector<Edge> between;
    levels_.push_back(make_level(vertices, edges));
    for (;;) {
        Level& fine = levels_.back();
        const std::size_t count = aggregate(fine);
        if (count == fine.size()) break;
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
        links[end[edge.a]++] = {edge.b, edge.conductance};
        links[end[edge.b]++] = {edge.a, edge.conductance};
    }
    // Of a vertex those to the same other one become one.
    level.first.reserve(vertices + 1);
    level.first.push_back(0);
    level.all.reserve(links.size());
    std::vector<std::uint32_t> last(vertices, kNone);  // link to each vertex
    for (std::size_t v = 0; v < vertices; ++v) {
        const std::size_t begin = level.all.size();
        double sum = 0;
        for (const Link& link : std::span(links).subspan(first[v], first[v + 1] - first[v])) {
            if (last[link.to] == kNone || last[link.to] < begin) {
                last[link.to] = static_cast<std::uint32_t>(level.all.size());
                level.all.push_back(link);
            } else {
                level.all[last[link.to]].conductance += link.conductance;
            }
            sum += link.conductance;
        }
        level.first.push_back(static_cast<std::uint32_t>(level.all.size()));
        level.sum.push_back(sum);
    }
    level.inflow.resize(vertices);
    level.potential.resize(vertices);
    return level;
}

/// Makes a vertex of the next level of each vertex none of whose neighbours belongs to one yet, and of these; what is
/// left goes with the neighbour that it is linked to best.
/// @returns  how many there are
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

inline double GraphSolver::Level::outflow(std::uint32_t v, std::span<const double> potentials) const {
    double flow = sum[v] * potentials[v];
    for (const Link& link : links(v)) flow -= link.conductance * potentials[link.to];
    return flow;
}

/// Sets a vertex' potential so that as much flows out as in.
inline void GraphSolver::relax(Level& level, std::uint32_t vertex) {
    if (!(level.sum[vertex] > 0)) return;
    double flow = level.inflow[vertex];
    for (const Link& link : level.links(vertex)) flow += link.conductance * level.potential[link.to];
    level.potential[vertex] = flow / level.sum[vertex];
}

/// Sets the potentials of a level to about what its inflow wants; the same way there and back, so that as an operator
/// it is symmetric.
void GraphSolver::cycle(std::size_t number) {
    Level& level = levels_[number];
    std::ranges::fill(level.potential, 0.0);
    if (level.coarse.empty()) return;  // nothing is linked any more
    const auto count = static_cast<std::uint32_t>(level.size());
    for (std::uint32_t v = 0; v < count; ++v) relax(level, v);
    Level& next = levels_[number + 1];
    std::ranges::fill(next.inflow, 0.0);
    for (std::uint32_t v = 0; v < count; ++v)
        next.inflow[level.coarse[v]] += level.inflow[v] - level.outflow(v, level.potential);
    cycle(number + 1);
    for (std::uint32_t v = 0; v < count; ++v) level.potential[v] += next.potential[level.coarse[v]];
    for (std::uint32_t v = count; v-- > 0;) relax(level, v);
}

void GraphSolver::solve(std::span<double> inflow, std::span<double> potential, int steps) {
    constexpr double kNegligible = 1e-24;  // what is left is rounding
    Level& finest = levels_.front();
    std::ranges::fill(potential, 0.0);
    std::ranges::fill(direction_, 0.0);
    double first = 0, last = 0;
    for (int step = 0; step < steps; ++step) {
        std::ranges::copy(inflow, finest.inflow.begin());
        cycle(0);
        const double now = product(inflow, finest.potential);
        if (step == 0) first = now;
        if (!(now > kNegligible * first)) return;
        const double kept = last > 0 ? now / last : 0;
        last = now;
        for (std::size_t v = 0; v < size(); ++v) direction_[v] = finest.potential[v] + kept * direction_[v];
        for (std::uint32_t v = 0; v < size(); ++v) image_[v] = finest.outflow(v, direction_);
        const double energy = product(direction_, image_);
        if (!(energy > 0)) return;
        for (std::size_t v = 0; v < size(); ++v) {
            potential[v] += now / energy * direction_[v];
            inflow[v] -= now / energy * image_[v];
        }
    }
}

}  // namespace ccdt
