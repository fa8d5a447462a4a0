// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/solid_mesh.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/surface/crease_vertices.h"
#include "core/ccdt/volume/tetrahedron_quality.h"

namespace ccdt {

namespace {

constexpr double kNearest = 0.5;  ///< least distance of vertices on the surface from each other, in spacings
/// Tetrahedra with all corners on the surface are left out if six times their volume is less than this share of the
/// cube of the longest edge at their first corner.
constexpr double kFlattest = 0.05;

/// Returns vertices on the surface: first those on creases, then the feet of the first layer of points.
/// @param creases  is set to the number of vertices on creases
std::vector<Point3> surface_vertices(const SolidDomain& domain, const VolumeSpacing& spacing,
                                     std::span<const Point3> points, std::size_t& creases) {
    const Surface& surface = domain.surface();
    std::vector<Point3> positions;
    std::vector<double> spacings;
    for (std::uint32_t v = 0; v < surface.vertex_count(); ++v)
        spacings.push_back(spacing.side(domain.in_box(surface.vertex(v))));
    const CreaseVertices chosen = choose_crease_vertices(surface, spacings, points.size());
    for (std::uint32_t v = 0; v < surface.vertex_count(); ++v) {
        if (chosen.corner[v] != 0) positions.push_back(surface.vertex(v));
    }
    for (const auto& [edge, share] : chosen.added) {
        const auto corners = surface.positions(edge / 4);
        positions.push_back((1 - share) * corners[edge % 4] + share * corners[(edge % 4 + 1) % 3]);
    }
    creases = positions.size();
    for (const Point3 p : points) {
        if (const auto foot = domain.foot_within(p, kFirstLayer * spacing.side(p))) positions.push_back(*foot);
    }
    if (positions.empty()) return positions;
    // Feet that are close to an earlier vertex are left out.
    const CellList3 cells(positions);
    std::vector<bool> kept(positions.size(), true);
    std::vector<Point3> apart;
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        const double least = kNearest * spacing.side(domain.in_box(positions[i]));
        cells.for_near(positions[i], least, [&](Point3 q, std::uint32_t j) {
            if (j < i && kept[j] && length(q - positions[i]) < least) kept[i] = i < creases;
        });
        if (kept[i]) apart.push_back(positions[i]);
    }
    return apart;
}

}  // namespace

TetrahedronMesh volume_mesh(const SolidDomain& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                            std::size_t free, const std::stop_token& stop) {
    std::size_t creases = 0;
    TetrahedronMesh mesh{{points.begin(), points.end()}, {}};
    std::vector<Point3>& vertices = mesh.vertices;
    const std::vector<Point3> added = surface_vertices(domain, spacing, points, creases);
    vertices.insert(vertices.end(), added.begin(), added.end());
    mesh.tetrahedra = delaunay_tetrahedra(vertices, stop);
    std::erase_if(mesh.tetrahedra, [&](const Tetrahedron& corners) {
        const Point3 a = vertices[corners[0]], u = vertices[corners[1]] - a, v = vertices[corners[2]] - a,
                     w = vertices[corners[3]] - a;
        if (!domain.contains(a + 0.25 * (u + v + w))) return true;
        const double longest = std::max({length(u), length(v), length(w)});
        const double flattest = std::ranges::min(corners) >= points.size() ? kFlattest : 0;
        return dot(cross(u, v), w) <= flattest * longest * longest * longest;
    });
    const std::size_t fixed = points.size() + creases;
    improve_tetrahedra(
        mesh, {},
        [&](std::uint32_t v, Point3 to) {
            if (v < free) return domain.contains(to) ? to : vertices[v];
            return v < fixed ? vertices[v] : domain.foot(to);
        },
        stop);
    return mesh;
}

}  // namespace ccdt
