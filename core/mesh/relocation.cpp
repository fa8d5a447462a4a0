// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/relocation.h"

#include <algorithm>
#include <vector>

#include "core/geometry/predicates.h"
#include "core/mesh/flips.h"

namespace ccdt {

namespace {

using Mesh = Triangulation;

/// Lists the half-edges that leave a site, counter-clockwise.
std::vector<std::uint32_t> edges_around(const Triangulation& mesh, std::uint32_t site) {
    std::vector<std::uint32_t> edges;
    mesh.for_edges(site, [&](std::uint32_t h) { edges.push_back(h); });
    return edges;
}

/// Flips edges away from a site until its degree is three.
/// @returns  false if the degree stays higher because no other edge can be flipped
bool isolate(Triangulation& mesh, std::uint32_t site) {
    // An edge can be flipped if both new triangles are counter-clockwise.
    const auto can_turn = [&](std::uint32_t h) {
        const Point here = mesh.point(site), there = mesh.point(mesh.target(h));
        const Point left = mesh.point(mesh.origin(Mesh::previous(h))),
                    right = mesh.point(mesh.origin(Mesh::previous(mesh.twin(h))));
        return orientation(here, right, left) > 0 && orientation(there, left, right) > 0;
    };
    for (auto edges = edges_around(mesh, site); edges.size() > 3; edges = edges_around(mesh, site)) {
        const auto turned = std::ranges::find_if(edges, can_turn);
        if (turned == edges.end()) return false;
        mesh.flip(*turned);
    }
    return true;
}

/// Whether a position lies inside a triangle or on its edges; not for a torus.
bool is_within(const Triangulation& mesh, std::uint32_t triangle, Point p) {
    const auto [a, b, c] = mesh.positions(triangle);
    return orientation(a, b, p) >= 0 && orientation(b, c, p) >= 0 && orientation(c, a, p) >= 0;
}

}  // namespace

bool relocate_site(Triangulation& mesh, std::uint32_t site, std::uint32_t triangle, Point p) {
    std::vector<std::uint32_t> touched;  // triangles
    for (const std::uint32_t h : edges_around(mesh, site)) touched.push_back(Mesh::triangle_of(h));
    const bool isolated = isolate(mesh, site);
    if (isolated) {
        // Merges the three triangles around the site into one. The two free triangles then divide the triangle at the
        // new position.
        const auto edges = edges_around(mesh, site);
        const std::uint32_t h = edges[0], kept = Mesh::triangle_of(h), u = Mesh::triangle_of(edges[1]),
                            v = Mesh::triangle_of(edges[2]);
        mesh.triangles()[kept].corners[h % 4] = mesh.target(edges[2]);
        mesh.join(h, mesh.twin(Mesh::next(edges[2])));
        mesh.join(Mesh::previous(h), mesh.twin(Mesh::next(edges[1])));
        mesh.points()[site] = p;
        if (std::ranges::find(touched, triangle) != touched.end()) {
            // The merge has changed the triangles here. So the triangle that contains the position is looked up again.
            triangle = *std::ranges::find_if(
                touched, [&](std::uint32_t t) { return t != u && t != v && is_within(mesh, t, p); });
        }
        mesh.set_part(site, mesh.part_of(mesh.corners(triangle)[0]));
        mesh.divide(site, triangle, {}, u, v);
        touched.push_back(triangle);
    }
    Region whole;
    for (const std::uint32_t t : touched) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            mesh.keep_edge(Mesh::edge(t, i));
            whole.stack.push_back(Mesh::edge(t, i));
        }
    }
    legalise(mesh, whole);
    return isolated;
}

}  // namespace ccdt
