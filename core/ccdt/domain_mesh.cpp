// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/domain_mesh.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include "core/geometry/delaunay.h"
#include "core/mesh/inside.h"

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
        // Vertices on edges are rounded, which can make nearly touching edges cross.
        border = bare_border(domain);
        scaffold = triangulate(border, stop);
    }
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    if (!scaffold) return failure(ErrorCode::Internal, "the domain cannot be triangulated");
    return DomainMesh{std::move(border), mesh_of_border(sites, *scaffold)};
}

std::vector<std::size_t> sites_of_parts(const DomainMesh& mesh, const CapacityIntegral& capacity) {
    std::vector<double> due(mesh.mesh.part_count(), 0);
    auto vertex = static_cast<std::uint32_t>(mesh.mesh.site_count());
    for (const auto& loop : mesh.border.loops) {
        double inside = 0;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Point a = loop[i], b = loop[(i + 1) % loop.size()];
            inside += capacity.is_uniform() ? cross(a - loop[0], b - loop[0]) / 2 : capacity.along(a, b);
        }
        due[mesh.mesh.part_of(vertex)] += inside;
        vertex += static_cast<std::uint32_t>(loop.size());
    }
    double all = 0;
    for (double& each : due) all += each = std::max(0.0, each);
    if (!(all > 0)) return {};
    std::size_t left = mesh.mesh.site_count();
    std::vector<std::size_t> shares;
    std::vector<std::pair<double, std::size_t>> remainders;
    for (double each : due) {
        each *= static_cast<double>(mesh.mesh.site_count()) / all;
        shares.push_back(std::min(left, static_cast<std::size_t>(each)));
        left -= shares.back();
        remainders.emplace_back(static_cast<double>(shares.back()) - each, remainders.size());
    }
    std::ranges::sort(remainders);
    for (std::size_t i = 0; left > 0; i = (i + 1) % remainders.size(), --left) ++shares[remainders[i].second];
    return shares;
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
