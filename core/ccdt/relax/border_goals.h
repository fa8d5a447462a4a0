// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/relax/triangle_goals.h"
#include "core/geometry/hexagonal_spacing.h"

// The goals of triangles that touch a border or fixed sites. A mesh is a Triangulation or a SurfaceTriangulation;
// goals.h explains the goals.
namespace ccdt {

/// Sums over triangles, from which the capacity variation follows. The unit of capacities and targets is half a site's
/// capacity.
struct CapacitySums {
    double targets = 0;
    double sum = 0;      ///< sum of capacities
    double squares = 0;  ///< sum of capacity^2 / target
    double even = 0;     ///< sum of the targets of triangles that count as even, whatever their capacities are

    void add(double reached, double target) {
        targets += target;
        sum += reached;
        squares += reached * reached / target;
    }

    void add(const CapacitySums& other) {
        targets += other.targets;
        sum += other.sum;
        squares += other.squares;
        even += other.even;
    }

    /// Returns the standard deviation of capacity / target, divided by the mean of capacity / target. Both are weighted
    /// by the targets.
    double variation() const {
        if (!(sum > 0)) return 0;
        const double mean = sum / targets;
        const double uneven = targets / (targets + even);
        return std::sqrt(std::max(0.0, squares / targets - mean * mean) * uneven) / mean;
    }
};

/// Returns the border edge of a triangle with a site, which is opposite to the site; kNone if there is none.
template <class Mesh>
std::uint32_t border_edge(const Mesh& mesh, std::uint32_t triangle) {
    for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t h = Mesh::edge(triangle, i);
        if (mesh.twin(h) == Mesh::kNone) return h;
    }
    return Mesh::kNone;
}

/// Returns the site opposite to a border edge; kNone if the opposite vertex is on the border.
template <class Mesh>
std::uint32_t facing_site(const Mesh& mesh, std::uint32_t edge) {
    const std::uint32_t apex = mesh.origin(Mesh::previous(edge));
    return mesh.is_site(apex) ? apex : Mesh::kNone;
}

/// Returns the edge between two fixed sites in a triangle with a free site; kNone if there is none.
template <class Mesh>
std::uint32_t fixed_edge(const Mesh& mesh, std::uint32_t triangle) {
    const auto is_fixed = [&](std::uint32_t v) { return mesh.is_site(v) && !mesh.is_free(v); };
    for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t h = Mesh::edge(triangle, i);
        if (is_fixed(mesh.origin(h)) && is_fixed(mesh.target(h)) && mesh.is_free(mesh.origin(Mesh::previous(h))))
            return h;
    }
    return Mesh::kNone;
}

/// Returns the edge opposite to a triangle's site if it is a border edge or joins two fixed sites; else kNone. The
/// target of the triangle depends on the length of this edge.
template <class Mesh>
std::uint32_t faced_edge(const Mesh& mesh, std::uint32_t triangle) {
    const std::uint32_t edge = border_edge(mesh, triangle);
    return edge == Mesh::kNone && mesh.free_count() < mesh.site_count() ? fixed_edge(mesh, triangle) : edge;
}

/// Returns the length of an edge relative to the hexagonal distance of sites; 0 if there are no sites.
/// @param weight  sites per area near the edge; infinite in a triangle without area, whose edges count as 0
template <class Mesh>
double relative_length(const Mesh& mesh, std::uint32_t edge, double weight) {
    if (!(weight > 0)) return 0;
    const auto along = mesh.along(edge);
    const double spacing = hexagonal_spacing(weight);
    return spacing > 0 ? std::sqrt(dot(along, along)) / spacing : 0;
}

/// Returns the total length of the edges that a site faces (see faced_edge), relative to the hexagonal distance.
/// @param weight_of  returns the weight of a triangle
template <class Mesh, class WeightOf>
double faced_length(const Mesh& mesh, std::uint32_t site, WeightOf&& weight_of) {
    double sum = 0;
    std::uint32_t h = mesh.edge_of(site);
    do {
        const std::uint32_t triangle = Mesh::triangle_of(h), edge = faced_edge(mesh, triangle);
        if (edge != Mesh::kNone && mesh.origin(Mesh::previous(edge)) == site)
            sum += relative_length(mesh, edge, weight_of(triangle));
        h = mesh.twin(Mesh::previous(h));
    } while (h != mesh.edge_of(site));
    return sum;
}

/// Caches the total length of the edges that each site faces, since a site may face thousands of edges.
template <class Mesh, class WeightOf>
class FacedLengths {
public:
    FacedLengths(const Mesh& mesh, const WeightOf& weight_of) : mesh_(mesh), weight_of_(weight_of) {}

    double operator()(std::uint32_t site) {
        const auto [known, is_new] = known_.try_emplace(site, 0);
        if (is_new) known->second = faced_length(mesh_, site, weight_of_);
        return known->second;
    }

private:
    const Mesh& mesh_;
    const WeightOf& weight_of_;
    std::unordered_map<std::uint32_t, double> known_;
};

/// Returns the goal of a triangle with a free site.
template <class Mesh, class WeightOf>
TriangleGoal goal_of(const Mesh& mesh, std::uint32_t triangle, const WeightOf& weight_of,
                     FacedLengths<Mesh, WeightOf>& faced_lengths) {
    constexpr double kEdgeShare = 0.5;  // share of the strip; triangles with one border vertex get the rest
    // Target of a triangle with one border vertex. A smaller value crowds sites at the border, a larger one empties it:
    // benchmark BorderPattern.
    constexpr double kCornerShare = 0.61;
    // Least share, reached in a fan of 1,000 triangles. It keeps the terms in the equations of one vertex comparable.
    constexpr double kMinShare = 1e-3;
    const double weight = weight_of(triangle);
    const bool touches_border =
        !std::ranges::all_of(mesh.corners(triangle), [&](std::uint32_t v) { return mesh.is_site(v); });
    const std::uint32_t edge = faced_edge(mesh, triangle);
    if (edge == Mesh::kNone) return {weight, touches_border ? kCornerShare : 1, 1};
    const double own = relative_length(mesh, edge, weight);
    const double all = std::min(1.0, faced_lengths(facing_site(mesh, edge)));
    // The first row is half a row away from the border, but a whole row away from fixed sites.
    return {weight, touches_border ? kEdgeShare * own : std::min(1.0, own),
            own < all ? std::max(kMinShare, own / all) : 1};
}

template <class Mesh>
bool is_any_free(const Mesh& mesh, std::uint32_t triangle) {
    return std::ranges::any_of(mesh.corners(triangle), [&](std::uint32_t v) { return mesh.is_free(v); });
}

/// Sums over all triangles, and the goals of the triangles that need goals of their own.
struct BorderGoals {
    CapacitySums reached;
    std::vector<std::uint32_t> triangles;  ///< triangles with a corner that is not a free site, in ascending order
    std::vector<TriangleGoal> goals;       ///< goals of these triangles; all other triangles have target and share 1
};

/// Returns the sums over all triangles, and the goals of the triangles with a corner that is not a free site.
/// @param reached_by, weight_of  return the capacity and the weight of a triangle, in units of half a site's capacity
/// @param in_row                 [sites] whether a site lies in a row with equal capacities; may be empty. Triangles
///                               all of whose sites lie in rows count as even. Targets assume further rows beside a
///                               row; where the domain is narrower than the spacing, the capacities would only show its
///                               width
template <class Mesh, class ReachedBy, class WeightOf>
BorderGoals find_border_goals(const Mesh& mesh, ReachedBy&& reached_by, const WeightOf& weight_of,
                              std::span<const std::uint8_t> in_row = {}) {
    constexpr std::size_t kRange = 8192;  // triangles per task
    constexpr double kMinTarget = 1e-9;   // smaller targets consist of rounding errors
    const std::size_t count = mesh.triangle_count();
    const auto is_even = [&](std::uint32_t t) {
        return !in_row.empty() && std::ranges::all_of(mesh.corners(t), [&](std::uint32_t v) {
            return !mesh.is_site(v) || in_row[v] != 0;
        });
    };
    std::vector<BorderGoals> parts((count + kRange - 1) / kRange);
    for_ranges(mesh.executor(), count, kRange, [&](std::size_t begin, std::size_t end) {
        BorderGoals own;
        FacedLengths faced_lengths(mesh, weight_of);
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
            const double reached = reached_by(t);
            const auto add = [&](double target) {
                if (is_even(t))
                    own.reached.even += target;
                else
                    own.reached.add(reached, target);
            };
            if (std::ranges::all_of(mesh.corners(t), [&](std::uint32_t v) { return mesh.is_free(v); })) {
                add(1);
                continue;
            }
            const bool moves = is_any_free(mesh, t);  // otherwise no corner is free to move
            const TriangleGoal goal =
                moves ? goal_of(mesh, t, weight_of, faced_lengths) : TriangleGoal{weight_of(t), reached, 1};
            if (moves && goal.target >= kMinTarget) add(goal.target);
            own.triangles.push_back(t);
            own.goals.push_back(goal);
        }
        parts[begin / kRange] = std::move(own);
    });
    BorderGoals all;
    for (const BorderGoals& part : parts) {
        all.reached.add(part.reached);
        all.triangles.insert(all.triangles.end(), part.triangles.begin(), part.triangles.end());
        all.goals.insert(all.goals.end(), part.goals.begin(), part.goals.end());
    }
    return all;
}

}  // namespace ccdt
