// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/site_relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/ccdt/relax/border_goals.h"
#include "core/ccdt/relax/relaxation.h"
#include "core/ccdt/surface/site_order.h"
#include "core/geometry/point.h"
#include "core/mesh/move_guard.h"

namespace ccdt {

namespace {

constexpr std::size_t kTriangles = 8192;    ///< triangles per task
constexpr std::size_t kMaxNeighbours = 64;  ///< sites with more neighbours are not moved

}  // namespace

/// The neighbours of a site, rotated into the tangent plane of the site.
struct SiteRelaxation::Ring {
    /// Coordinates of the neighbours, relative to the site. The first neighbour is repeated at the end.
    template <std::size_t kAxes>
    using Coordinates = std::array<std::array<double, kMaxNeighbours + 1>, kAxes>;

    std::size_t count = 0;
    Coordinates<3> positions;
    Coordinates<2> flat;                                  ///< in the tangent plane
    std::array<std::uint32_t, kMaxNeighbours> triangles;  ///< triangle between each neighbour and the next one
    std::array<double, kMaxNeighbours> areas;             ///< doubled areas of these triangles
    Point3 x, y;                                          ///< axes of the plane

    Point3 position(std::size_t i) const { return {positions[0][i], positions[1][i], positions[2][i]}; }
    Point in_plane(std::size_t i) const { return {flat[0][i], flat[1][i]}; }

    /// @returns  false if the neighbours do not determine a plane, or are too many
    bool gather(const SurfaceTriangulation& mesh, std::uint32_t site) {
        mesh.for_edges(site, [&](std::uint32_t h) {
            if (count < kMaxNeighbours) {
                const Point3 p = mesh.toward(site, mesh.target(h));
                positions[0][count] = p.x, positions[1][count] = p.y, positions[2][count] = p.z;
                triangles[count] = SurfaceTriangulation::triangle_of(h);
            }
            ++count;
        });
        if (count < 3 || count > kMaxNeighbours) return false;
        for (auto& axis : positions) axis[count] = axis[0];
        Point3 normal;
        for (std::size_t i = 0; i < count; ++i) {
            const Point3 doubled = cross(position(i), position(i + 1));
            areas[i] = length(doubled);
            normal = normal + doubled;
        }
        const double doubled = length(normal);
        if (!(doubled > 0)) return false;
        normal = 1 / doubled * normal;
        x = position(0) - dot(position(0), normal) * normal;
        if (!(length(x) > 0)) return false;
        x = 1 / length(x) * x;
        y = cross(normal, x);
        for (std::size_t i = 0; i < count; ++i) {
            const Point3 p = position(i);
            const double u = dot(p, x), v = dot(p, y), projected = u * u + v * v;
            const double scale = projected > 0 ? std::sqrt(dot(p, p) / projected) : 1;
            flat[0][i] = scale * u;
            flat[1][i] = scale * v;
        }
        for (auto& axis : flat) axis[count] = axis[0];
        return true;
    }
};

SiteRelaxation::SiteRelaxation(SurfaceTriangulation& mesh, const SurfaceDensity& density, double capacity)
    : mesh_(mesh), density_(density), capacity_(capacity) {}

double SiteRelaxation::variation(std::span<const std::uint8_t> in_row) {
    goals_.assign(mesh_.triangle_count(), {});
    for_ranges(mesh_.executor(), goals_.size(), kTriangles, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
            double density = 0;
            for (const std::uint32_t corner : mesh_.corners(t)) density += density_.at(mesh_.on_surface(corner)) / 3;
            goals_[t].weight = density / capacity_;
        }
    });
    const auto weight_of = [&](std::uint32_t t) { return goals_[t].weight; };
    const BorderGoals border_goals = find_border_goals(
        mesh_, [&](std::uint32_t t) { return goals_[t].weight * mesh_.doubled_area(t); }, weight_of, in_row);
    for (std::size_t i = 0; i < border_goals.goals.size(); ++i)
        goals_[border_goals.triangles[i]] = border_goals.goals[i];
    return border_goals.reached.variation();
}

void SiteRelaxation::pass(int passes, const std::stop_token& stop) {
    const SiteOrder order(mesh_, [](std::uint32_t) { return true; });
    for (int i = 0; i < passes && !stop.stop_requested(); ++i)
        order.for_sites(stop, [&](std::uint32_t site) { move(site); });
}

void SiteRelaxation::move(std::uint32_t site) {
    Ring ring;
    if (!ring.gather(mesh_, site)) return;
    // The normal equations of the sum of (weight * doubled area - target)^2 / share, and of the springs. After a move
    // m, the doubled area is area - cross(m, edge).
    double xx = 0, xy = 0, yy = 0;
    Point right;
    for (std::size_t i = 0; i < ring.count; ++i) {
        const TriangleGoal& goal = goals_[ring.triangles[i]];
        const Point edge = ring.in_plane(i + 1) - ring.in_plane(i);
        const double weight = goal.weight / goal.share, spring = kSpring * goal.weight * goal.share;
        const Point slope{-goal.weight * edge.y, goal.weight * edge.x}, weighted{-weight * edge.y, weight * edge.x};
        xx += slope.x * weighted.x + spring;
        xy += slope.x * weighted.y;
        yy += slope.y * weighted.y + spring;
        right = right + (goal.target - goal.weight * ring.areas[i]) * weighted + spring * ring.in_plane(i);
    }
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 0)) return;
    Point move{(yy * right.x - xy * right.y) / determinant, (xx * right.y - xy * right.x) / determinant};
    move = kRelaxation * move;
    double share = 1;
    for (std::size_t i = 0; i < ring.count; ++i) {
        const Point a = ring.in_plane(i), b = ring.in_plane(i + 1);
        const double lost = cross(move, b - a), most = (1 - kKeptShare) * cross(a, b);
        if (lost > most) share = std::min(share, std::max(0.0, most / lost));
    }
    move = share * move;
    mesh_.move(site, move.x * ring.x + move.y * ring.y);
}

}  // namespace ccdt
