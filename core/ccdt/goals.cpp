#include "core/ccdt/goals.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/hexagonal_spacing.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = Triangulation::kNone;
constexpr std::size_t kRange = 8192;  ///< triangles that a task takes

/// Sums over triangles.
struct Reached {
    double targets = 0;
    double sum = 0;
    double squares = 0;  ///< over the targets
};

/// The edge of the border that a triangle with a site lies on; there can be no second one, as the others end in it.
std::uint32_t border_edge(const Triangulation& mesh, std::uint32_t triangle) {
    for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t h = Triangulation::edge(triangle, i);
        if (mesh.twin(h) == kNone) return h;
    }
    return kNone;
}

/// The site that faces an edge of the border; kNone if another vertex of the border does.
std::uint32_t facing_site(const Triangulation& mesh, std::uint32_t edge) {
    const std::uint32_t apex = mesh.origin(Triangulation::previous(edge));
    return mesh.is_site(apex) ? apex : kNone;
}

/// The edge between two fixed sites of a triangle that has a free one; kNone if there is no such edge.
std::uint32_t fixed_edge(const Triangulation& mesh, std::uint32_t triangle) {
    const auto is_fixed = [&](std::uint32_t v) { return mesh.is_site(v) && !mesh.is_free(v); };
    for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t h = Triangulation::edge(triangle, i);
        if (is_fixed(mesh.origin(h)) && is_fixed(mesh.target(h)) &&
            mesh.is_free(mesh.origin(Triangulation::previous(h))))
            return h;
    }
    return kNone;
}

/// The edge that the site at the triangle's third corner faces, if its target goes with the edge's length: of the
/// border, or between fixed sites.
std::uint32_t faced_edge(const Triangulation& mesh, std::uint32_t triangle) {
    const std::uint32_t edge = border_edge(mesh, triangle);
    return edge == kNone && mesh.free_count() < mesh.site_count() ? fixed_edge(mesh, triangle) : edge;
}

/// Length of an edge in units of the spacing of sites.
double length(const Triangulation& mesh, std::uint32_t edge, double weight) {
    const Point along = mesh.along(edge);
    return weight > 0 ? std::sqrt(dot(along, along)) / hexagonal_spacing(weight) : 0;
}

/// Sets the target of a triangle with a site, and its share of a triangle.
/// @param faced  [sites] lengths of the edges of the border that each faces, together
void aim(const Triangulation& mesh, std::uint32_t triangle, const std::vector<double>& faced, TriangleGoal& goal) {
    constexpr double kEdgeShare = 0.5;     // of the strip; the other half goes to the corners
    constexpr double kCornerShare = 0.61;  // benchmark BorderPattern: less crowds sites at the border, more shuns it
    constexpr double kLeastShare = 1e-3;   // of a fan of a thousand triangles: keeps the terms of one vertex comparable
    const auto corners = mesh.corners(triangle);
    const bool touches_border = !std::ranges::all_of(corners, [&](std::uint32_t v) { return mesh.is_site(v); });
    const std::uint32_t edge = faced_edge(mesh, triangle);
    goal.share = 1;
    if (edge == kNone) {
        goal.target = touches_border ? kCornerShare : 1;
        return;
    }
    const double own = length(mesh, edge, goal.weight), all = std::min(1.0, faced[facing_site(mesh, edge)]);
    // The first row is half a row from the border, and a whole one from fixed sites.
    goal.target = touches_border ? kEdgeShare * own : std::min(1.0, own);
    if (own < all) goal.share = std::max(kLeastShare, own / all);
}

}  // namespace

double set_goals(const Triangulation& mesh, const CapacityIntegral& capacity, const std::vector<double>& capacities,
                 std::vector<TriangleGoal>& goals) {
    return set_goals(mesh, capacity.total(), capacity.densest(), capacities, goals);
}

double set_goals(const Triangulation& mesh, double total, double densest, const std::vector<double>& capacities,
                 std::vector<TriangleGoal>& goals) {
    constexpr double kLeastTarget = 1e-9;  // less is rounding
    const double unit = 2 * static_cast<double>(mesh.site_count()) / total;
    const double largest_weight = unit * densest;
    const auto reached_by = [&](std::uint32_t t) { return unit * std::max(0.0, capacities[t]); };
    std::vector<double> faced(mesh.site_count(), 0);
    goals.resize(mesh.triangle_count());
    std::vector<std::vector<std::pair<std::uint32_t, double>>> lists((goals.size() + kRange - 1) / kRange);
    for_ranges(mesh.team(), goals.size(), kRange, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
            const double area = mesh.doubled_area(t);
            goals[t].weight = area > 0 ? std::min(reached_by(t) / area, largest_weight) : largest_weight;
            const std::uint32_t edge = faced_edge(mesh, t), site = edge == kNone ? kNone : facing_site(mesh, edge);
            if (site != kNone) lists[begin / kRange].emplace_back(site, length(mesh, edge, goals[t].weight));
        }
    });
    for (const auto& list : lists) {
        for (const auto& [site, length] : list) faced[site] += length;
    }

    std::vector<Reached> parts(lists.size());
    for_ranges(mesh.team(), goals.size(), kRange, [&](std::size_t begin, std::size_t end) {
        Reached own;
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
            const double reached = reached_by(t);
            TriangleGoal& goal = goals[t];
            if (std::ranges::none_of(mesh.corners(t), [&](std::uint32_t v) { return mesh.is_free(v); })) {
                goal = {.weight = goal.weight, .target = reached};  // nothing there can move it
                continue;
            }
            aim(mesh, t, faced, goal);
            if (goal.target < kLeastTarget) continue;
            own.targets += goal.target;
            own.sum += reached;
            own.squares += reached * reached / goal.target;
        }
        parts[begin / kRange] = own;
    });
    Reached all;
    for (const Reached& part : parts) {
        all.targets += part.targets;
        all.sum += part.sum;
        all.squares += part.squares;
    }

    // Mean and variance of reached / target, each triangle weighing as much as its target.
    if (!(all.sum > 0)) return 0;
    const double mean = all.sum / all.targets;
    return std::sqrt(std::max(0.0, all.squares / all.targets - mean * mean)) / mean;
}

}  // namespace ccdt
