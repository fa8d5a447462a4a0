#include "tests/support/meshes.h"

#include <stdexcept>
#include <utility>

#include "core/ccdt/placement.h"
#include "core/ccdt/start.h"
#include "core/geometry/delaunay.h"

namespace ccdt::test {

Domain domain_of(const Parts& parts) {
    return Domain::create(parts).value();
}

StartMesh::StartMesh(Domain of, Density by, const Options& options)
    : domain(std::move(of)),
      density(std::move(by)),
      capacity(domain, density),
      border(make_border(domain, capacity, options.sites)),
      mesh(options.sites, triangulate(border).value()) {
    const StartSites start(domain, density, options);
    if (place_sites(mesh, start, options.seed, 0, {})) throw std::runtime_error("sites cannot be placed");
    mesh.trim();
}

double StartMesh::measure() {
    capacity.of_triangles(mesh, capacities);
    return set_goals(mesh, capacity, capacities, goals);
}

std::size_t count_inverted(const Triangulation& mesh) {
    std::size_t inverted = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        if (exact_orientation(mesh.point(a), mesh.point(b), mesh.point(c)) <= 0) ++inverted;
    }
    return inverted;
}

std::size_t count_not_delaunay(const Triangulation& mesh) {
    std::size_t bad = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t twin = mesh.twin(Triangulation::edge(t, i));
            if (twin == Triangulation::kNone) continue;
            const Point opposite = mesh.point(mesh.origin(Triangulation::previous(twin)));
            if (exact_in_circle(mesh.point(a), mesh.point(b), mesh.point(c), opposite) > 0) ++bad;
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
        }
    }
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const std::uint32_t h = mesh.edge_of(v);
        if (mesh.origin(h) != v || (mesh.twin(h) == Triangulation::kNone) == mesh.is_site(v)) ++bad;
    }
    return bad;
}

}  // namespace ccdt::test
