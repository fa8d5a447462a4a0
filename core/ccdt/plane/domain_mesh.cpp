// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/domain_mesh.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include "core/geometry/apportion.h"
#include "core/geometry/delaunay.h"
#include "core/mesh/inside.h"

namespace ccdt {

namespace {

std::vector<Point> to_user(const Domain& domain, std::span<const Point> positions) {
    std::vector<Point> points;
    points.reserve(positions.size());
    for (const Point& p : positions) points.push_back(domain.to_user(p));
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
        // Vertices on edges are rounded, which can make nearly touching edges cross.
        border = bare_border(domain);
        scaffold = triangulate(border, stop);
    }
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    if (!scaffold) return failure(ErrorCode::Internal, "the domain cannot be triangulated");
    return DomainMesh{std::move(border), mesh_of_border(sites, *scaffold)};
}

std::vector<std::size_t> sites_of_parts(const DomainMesh& mesh, const CapacityIntegral& capacity) {
    struct Part {
        double capacity = 0;
        double area = 0;  ///< doubled
        Point moment;     ///< integral of position over the area, times 6
    };
    std::vector<Part> parts(mesh.mesh.part_count());
    auto vertex = static_cast<std::uint32_t>(mesh.mesh.site_count());
    for (const auto& loop : mesh.border.loops) {
        Part& part = parts[mesh.mesh.part_of(vertex)];
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Point a = loop[i], b = loop[(i + 1) % loop.size()];
            const double area = cross(a - loop[0], b - loop[0]);
            part.capacity += capacity.is_uniform() ? area / 2 : capacity.along(a, b);
            part.area += area;
            part.moment = part.moment + area * (loop[0] + a + b);
        }
        vertex += static_cast<std::uint32_t>(loop.size());
    }
    double all = 0;
    for (Part& part : parts) all += part.capacity = std::max(0.0, part.capacity);
    if (!(all > 0)) return {};
    std::vector<double> quotas;
    std::vector<Point3> positions;
    for (const Part& part : parts) {
        quotas.push_back(part.capacity / all * static_cast<double>(mesh.mesh.site_count()));
        const Point middle{part.moment.x / (3 * part.area), part.moment.y / (3 * part.area)};
        positions.push_back(part.area > 0 ? Point3{middle.x, middle.y, 0} : Point3{});
    }
    return std::move(apportion(positions, {&quotas, 1}).front());
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
