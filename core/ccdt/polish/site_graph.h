// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/polish/graph_solver.h"
#include "core/geometry/point.h"
#include "core/geometry/point3.h"

// The graph on which an excess of sites flows. Its edges are those of a mesh: a Triangulation, trimmed and not of a
// torus, or a SurfaceTriangulation.
namespace ccdt {

/// Returns the area of the parallelogram with the sides a and b; in the plane, negative if b is clockwise from a.
inline double parallelogram_area(Point a, Point b) {
    return cross(a, b);
}
inline double parallelogram_area(Point3 a, Point3 b) {
    return length(cross(a, b));
}

/// Returns the site with which each vertex is merged [vertices]. A site is merged with itself. A border vertex, which
/// is any other vertex, is merged with the nearest site that an edge joins to it, or else with the site of an adjacent
/// border vertex. In a part without sites, the entry is kNone.
template <class Mesh>
std::vector<std::uint32_t> owners(const Mesh& mesh) {
    struct Half {
        std::uint32_t from, to;
        double squared;
    };
    std::vector<Half> edges;  // all half-edges that end on the border
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto corners = mesh.corners(t);
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t a = corners[i], b = corners[(i + 1) % 3];
            if (mesh.is_site(a) && mesh.is_site(b)) continue;
            const auto along = mesh.point(b) - mesh.point(a);
            if (!mesh.is_site(a)) edges.push_back({b, a, dot(along, along)});
            if (!mesh.is_site(b)) edges.push_back({a, b, dot(along, along)});
        }
    }
    std::vector<std::uint32_t> owner(mesh.vertex_count(), Mesh::kNone);
    for (std::uint32_t v = 0; v < mesh.site_count(); ++v) owner[v] = v;
    std::vector<double> nearest(mesh.vertex_count());
    for (bool found = true; found;) {
        found = false;
        const std::vector<std::uint32_t> before = owner;
        for (const auto& [from, to, squared] : edges) {
            if (before[from] == Mesh::kNone || before[to] != Mesh::kNone) continue;
            if (owner[to] != Mesh::kNone && squared >= nearest[to]) continue;
            owner[to] = before[from];
            nearest[to] = squared;
            found = true;
        }
        std::erase_if(edges, [&](const Half& edge) { return owner[edge.to] != Mesh::kNone; });
    }
    return owner;
}

/// Lists the edges that `passes` accepts, with the conductances of linear finite elements. Border vertices are merged
/// with sites.
/// @param passes  returns whether the excess may flow along the edge between two sites
template <class Mesh, class Passes>
std::vector<GraphSolver::Edge> edges_between_sites(const Mesh& mesh, Passes&& passes) {
    constexpr std::size_t kTriangles = 8192;  // triangles per task
    // Bounds on conductances, which needles can exceed. At an edge of the border, two triangles can give a negative
    // value, which counts as no conductance.
    constexpr double kMin = 1e-3, kMax = 2;
    // Doubled area relative to squared sides. In thinner triangles, angles consist of rounding errors.
    constexpr double kThinnest = 1e-12;
    const auto owner = owners(mesh);
    // Cotangents of the angles opposite to the edges.
    std::vector<std::array<double, 3>> cotangents(mesh.triangle_count());
    for_ranges(mesh.executor(), cotangents.size(), kTriangles, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const auto [a, b, c] = mesh.positions(static_cast<std::uint32_t>(t));
            const auto ab = b - a, bc = c - b, ca = a - c;
            const double area = parallelogram_area(ab, bc);
            const double scale = area > kThinnest * (dot(ab, ab) + dot(bc, bc)) ? -1 / area : 0;
            cotangents[t] = {scale * dot(bc, ca), scale * dot(ca, ab), scale * dot(ab, bc)};
        }
    });
    std::vector<std::vector<GraphSolver::Edge>> lists((cotangents.size() + kTriangles - 1) / kTriangles);
    for_ranges(mesh.executor(), cotangents.size(), kTriangles, [&](std::size_t begin, std::size_t end) {
        auto& list = lists[begin / kTriangles];
        list.reserve(3 * (end - begin) / 2 + 3);
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
            const auto corners = mesh.corners(t);
            for (std::uint32_t i = 0; i < 3; ++i) {
                const std::uint32_t h = Mesh::edge(t, i), twin = mesh.twin(h);
                if (twin != Mesh::kNone && twin < h) continue;
                const std::uint32_t a = owner[corners[i]], b = owner[corners[(i + 1) % 3]];
                if (a == b || a == Mesh::kNone || b == Mesh::kNone || !passes(a, b)) continue;
                const double other = twin == Mesh::kNone ? 0 : cotangents[Mesh::triangle_of(twin)][twin % 4];
                list.push_back({a, b, std::clamp((cotangents[t][i] + other) / 2, kMin, kMax)});
            }
        }
    });
    std::vector<GraphSolver::Edge> edges;
    edges.reserve(3 * mesh.site_count());
    for (const auto& list : lists) edges.insert(edges.end(), list.begin(), list.end());
    return edges;
}

}  // namespace ccdt
