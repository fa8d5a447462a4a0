#include "core/ccdt/domain_mesh.h"

#include <cstdint>
#include <span>
#include <utility>

#include "core/geometry/delaunay.h"

namespace ccdt {

namespace {

std::vector<Point> to_user(const Domain& domain, std::span<const Point> places) {
    std::vector<Point> points;
    points.reserve(places.size());
    for (const Point& p : places) points.push_back(domain.to_user(p));
    return points;
}

}  // namespace

Result<DomainMesh> empty_mesh(const Domain& domain, const CapacityIntegral& capacity, std::size_t sites,
                              const std::stop_token& stop) {
    if (domain.is_torus()) return DomainMesh{{}, Triangulation(sites, domain.unit_bounds().max)};
    return empty_mesh(domain, make_border(domain, capacity, sites), sites, stop);
}

Result<DomainMesh> empty_mesh(const Domain& domain, Border border, std::size_t sites, const std::stop_token& stop) {
    auto scaffold = triangulate(border, stop);
    if (!scaffold) {
        // Vertices set on the edges round off them; where two edges almost touch, that can make them cross.
        border = bare_border(domain);
        scaffold = triangulate(border, stop);
    }
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    if (!scaffold) return failure(ErrorCode::Internal, "the domain cannot be triangulated");
    return DomainMesh{std::move(border), Triangulation(sites, *scaffold)};
}

std::vector<Point> sites_to_user(const Domain& domain, const Triangulation& mesh) {
    return to_user(domain, {mesh.points().data(), mesh.site_count()});
}

TriangleMesh mesh_to_user(const Domain& domain, const Triangulation& mesh, const Border& border) {
    TriangleMesh copy;
    copy.vertices = to_user(domain, mesh.points());
    copy.triangles.reserve(mesh.triangle_count());
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) copy.triangles.push_back(mesh.corners(t));
    auto vertex = static_cast<std::uint32_t>(mesh.site_count());
    for (const auto& loop : border.loops) {
        auto& indices = copy.boundary.emplace_back(loop.size());
        for (std::uint32_t& index : indices) index = vertex++;
    }
    return copy;
}

}  // namespace ccdt
