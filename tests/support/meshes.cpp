// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/meshes.h"

#include <stdexcept>
#include <utility>

#include "core/ccdt/plane/placement.h"
#include "core/ccdt/plane/start.h"
#include "core/geometry/delaunay.h"
#include "core/mesh/inside.h"

namespace ccdt::test {

namespace {

Triangulation empty_mesh(const Domain& domain, const Border& border, std::size_t sites) {
    if (domain.is_torus()) return {sites, domain.unit_bounds().max};
    return mesh_of_border(sites, triangulate(border).value());
}

bool has_flat_triangle(const Triangulation& mesh, std::uint32_t site) {
    std::uint32_t h = mesh.edge_of(site);
    do {
        if (mesh.doubled_area(Triangulation::triangle_of(h)) < 1e-9) return true;
        h = mesh.twin(Triangulation::previous(h));
    } while (h != mesh.edge_of(site));
    return false;
}

}  // namespace

Domain domain_of(const Parts& parts) {
    return Domain::create(parts).value();
}

StartMesh::StartMesh(Domain of, Density by, const Options& options)
    : domain(std::move(of)),
      density(std::move(by)),
      capacity(domain, density),
      border(domain.is_torus() ? Border() : make_border(domain, capacity, options.sites)),
      mesh(empty_mesh(domain, border, options.sites)) {
    const StartSites start(domain, density, options);
    if (place_sites(mesh, {}, start, {}, options.seed, 0, {})) throw std::runtime_error("sites cannot be placed");
    trim(mesh);
}

double StartMesh::measure() {
    capacity.of_triangles(mesh, capacities);
    return set_goals(mesh, capacity, capacities, goals);
}

void stir(Triangulation& mesh, Random& random) {
    for (std::uint32_t v = 0; v < mesh.site_count(); ++v) {
        const Point old = mesh.point(v), moved = old + 0.5 * random.uniform() * mesh.along(mesh.edge_of(v));
        mesh.points()[v] = mesh.is_torus() ? snapped(moved) : moved;
        if (has_flat_triangle(mesh, v)) mesh.points()[v] = old;
    }
}

std::size_t count_inverted(const Triangulation& mesh) {
    std::size_t inverted = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.positions(t);
        if (exact_orientation(a, b, c) <= 0) ++inverted;
    }
    return inverted;
}

std::size_t count_not_delaunay(const Triangulation& mesh) {
    std::size_t bad = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.positions(t);
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i), twin = mesh.twin(h);
            if (twin == Triangulation::kNone) continue;
            const std::uint32_t beyond = Triangulation::next(twin);  // starts at the origin of h
            const Point opposite = mesh.point(mesh.target(beyond)) + mesh.distance(mesh.lift(h) + mesh.shift(beyond));
            if (exact_in_circle(a, b, c, opposite) > 0) ++bad;
        }
    }
    return bad;
}

std::size_t count_bad_links(const Triangulation& mesh) {
    std::size_t bad = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i), twin = mesh.twin(h);
            if (twin == Triangulation::kNone) {
                if (mesh.is_site(mesh.origin(h)) || mesh.is_site(mesh.target(h))) ++bad;
                continue;
            }
            if (mesh.twin(twin) != h || mesh.origin(twin) != mesh.target(h) || mesh.target(twin) != mesh.origin(h)) {
                ++bad;
            }
            if (mesh.shift(h) + mesh.shift(twin) != Shift{}) ++bad;
        }
        const std::uint32_t h = Triangulation::edge(t, 0);
        if (mesh.shift(h) + mesh.shift(h + 1) + mesh.shift(h + 2) != Shift{}) ++bad;
    }
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const std::uint32_t h = mesh.edge_of(v);
        if (mesh.origin(h) != v || (mesh.twin(h) == Triangulation::kNone) == mesh.is_site(v)) ++bad;
    }
    return bad;
}

}  // namespace ccdt::test
