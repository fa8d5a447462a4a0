// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/volume_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/volume/tetrahedron_quality.h"
#include "core/volume/voxel_density.h"

namespace ccdt {

namespace {

constexpr double kNarrowest = 6;  ///< least side of a torus whose tetrahedra are improved, in spacings
constexpr double kRim = 2;        ///< initial width of the rim of periodic copies, in spacings

double circumradius(Point3 a, Point3 b, Point3 c, Point3 d) {
    const Point3 u = b - a, v = c - a, w = d - a;
    const Point3 top = dot(u, u) * cross(v, w) + dot(v, v) * cross(w, u) + dot(w, w) * cross(u, v);
    return length(top) / (2 * std::abs(dot(u, cross(v, w))));
}

TetrahedronMesh torus_mesh(const BoxDomain3& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                           const std::stop_token& stop) {
    const auto count = static_cast<std::uint32_t>(points.size());
    const double diagonal = length(domain.sides);
    TetrahedronMesh mesh{{points.begin(), points.end()}, {}};
    for (double rim = kRim; !stop.stop_requested(); rim *= 1.5) {
        std::vector<Point3> places(points.begin(), points.end());
        std::vector<std::uint32_t> numbers(count);
        double narrowest = domain.sides.x + domain.sides.y + domain.sides.z;
        for (std::uint32_t i = 0; i < count; ++i) {
            numbers[i] = i;
            const double reach = std::min(rim * spacing.side(points[i]), diagonal);
            narrowest = std::min(narrowest, reach);
            domain.for_copies(points[i], reach, [&](Point3 copy, bool is_original) {
                if (is_original) return;
                places.push_back(copy);
                numbers.push_back(i);
            });
        }
        mesh.tetrahedra.clear();
        double widest = 0;
        for (const Tetrahedron& corners : delaunay_tetrahedra(places, stop)) {
            // Of all periodic copies of a tetrahedron, the mesh contains the one whose lowest vertex is an original.
            const auto lowest = std::ranges::min(corners, {}, [&](std::uint32_t corner) {
                return std::array{numbers[corner], corner};
            });
            if (lowest >= count) continue;
            const auto& [a, b, c, d] = corners;
            widest = std::max(widest, 2 * circumradius(places[a], places[b], places[c], places[d]));
            mesh.tetrahedra.push_back({numbers[a], numbers[b], numbers[c], numbers[d]});
        }
        // All copies are known in the circumsphere of every tetrahedron then. No sphere without points is wider than
        // the diagonal, but a computed radius may be, by rounding errors.
        if (widest <= narrowest || narrowest >= diagonal) break;
    }
    return mesh;
}

TetrahedronMesh box_mesh(const BoxDomain3& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                         const std::stop_token& stop) {
    TetrahedronMesh mesh{{points.begin(), points.end()}, {}};
    std::vector<Point3>& vertices = mesh.vertices;
    for (const Point3 p : points) {
        std::vector<Point3> projections{p};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double v = along(p, axis), side = along(domain.sides, axis);
            const double face = v < side - v ? 0 : side;
            if (std::abs(v - face) > kFirstLayer * spacing.side(p)) continue;
            const std::size_t so_far = projections.size();
            for (std::size_t i = 0; i < so_far; ++i) {
                Point3 projection = projections[i];
                along(projection, axis) = face;
                projections.push_back(projection);
            }
        }
        // The last one of eight projections is a corner of the box, which is added below.
        const bool has_corner = projections.size() == 8;
        vertices.insert(vertices.end(), projections.begin() + 1, projections.end() - (has_corner ? 1 : 0));
    }
    for (const double z : {0.0, domain.sides.z}) {
        for (const double y : {0.0, domain.sides.y}) {
            for (const double x : {0.0, domain.sides.x}) vertices.push_back({x, y, z});
        }
    }
    mesh.tetrahedra = delaunay_tetrahedra(vertices, stop);
    return mesh;
}

}  // namespace

TetrahedronMesh volume_mesh(const BoxDomain3& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                            std::size_t free, const std::stop_token& stop) {
    TetrahedronMesh mesh =
        domain.periodic ? torus_mesh(domain, spacing, points, stop) : box_mesh(domain, spacing, points, stop);
    const Point3 sides = domain.sides;
    if (domain.periodic && std::min({sides.x, sides.y, sides.z}) < kNarrowest * spacing.mean()) return mesh;
    const auto slide = [&](std::uint32_t v, Point3 to) {
        if (v < free) return domain.inside(to);
        const Point3 from = mesh.vertices[v];
        if (v < points.size()) return from;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double side = along(sides, axis), own = along(from, axis);
            along(to, axis) = own == 0 || own == side ? own : std::clamp(along(to, axis), 0.0, side);
        }
        return to;
    };
    improve_tetrahedra(mesh, domain.periodic ? sides : Point3{}, slide, stop);
    return mesh;
}

}  // namespace ccdt
