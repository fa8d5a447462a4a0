// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/surface/site_relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/ccdt/triangle_aims.h"
#include "core/geometry/point.h"
#include "core/surface/site_order.h"

namespace ccdt {

namespace {

constexpr std::size_t kTriangles = 8192;     ///< triangles per task
constexpr std::size_t kMostNeighbours = 64;  ///< sites with more neighbours are not moved

// As in the plane: RelaxationOptions.
constexpr double kSpring = 0.01, kRelaxation = 1.2;

}  // namespace

/// The neighbours of a site, rotated into the tangent plane of the site.
struct SiteRelaxation::Ring {
    std::size_t count = 0;
    std::array<Point3, kMostNeighbours + 1> places;  ///< relative to the site; the first one is repeated at the end
    std::array<Point, kMostNeighbours + 1> flat;     ///< the same in the tangent plane
    std::array<std::uint32_t, kMostNeighbours> triangles;  ///< triangle between each neighbour and the next one
    Point3 x, y;                                           ///< axes of the plane

    /// @returns  false if the neighbours do not determine a plane, or are too many
    bool gather(const SurfaceTriangulation& mesh, std::uint32_t site) {
        const Point3 place = mesh.point(site);
        Point3 normal;
        mesh.for_edges(site, [&](std::uint32_t h) {
            if (count < kMostNeighbours) {
                places[count] = mesh.point(mesh.target(h)) - place;
                triangles[count] = SurfaceTriangulation::triangle_of(h);
                normal = normal + mesh.doubled_normal(triangles[count]);
            }
            ++count;
        });
        const double doubled = length(normal);
        if (count < 3 || count > kMostNeighbours || !(doubled > 0)) return false;
        normal = 1 / doubled * normal;
        x = places[0] - dot(places[0], normal) * normal;
        if (!(length(x) > 0)) return false;
        x = 1 / length(x) * x;
        y = cross(normal, x);
        for (std::size_t i = 0; i < count; ++i) {
            const Point p{dot(places[i], x), dot(places[i], y)};
            const double projected = std::sqrt(dot(p, p));
            flat[i] = projected > 0 ? length(places[i]) / projected * p : p;
        }
        places[count] = places[0];
        flat[count] = flat[0];
        return true;
    }
};

SiteRelaxation::SiteRelaxation(SurfaceTriangulation& mesh, const SurfaceDensity& density, double capacity)
    : mesh_(mesh), density_(density), capacity_(capacity) {}

/// Sets the goals of all triangles and returns the capacity variation.
double SiteRelaxation::set_goals() {
    goals_.assign(mesh_.triangle_count(), {});
    for_ranges(mesh_.executor(), goals_.size(), kTriangles, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
            double density = 0;
            for (const std::uint32_t corner : mesh_.corners(t)) density += density_.at(mesh_.on_surface(corner)) / 3;
            goals_[t].weight = density / capacity_;
        }
    });
    const auto weight_of = [&](std::uint32_t t) { return goals_[t].weight; };
    const Aims aims = find_aims(
        mesh_, [&](std::uint32_t t) { return goals_[t].weight * mesh_.doubled_area(t); }, weight_of);
    for (std::size_t i = 0; i < aims.goals.size(); ++i) goals_[aims.triangles[i]] = aims.goals[i];
    return aims.reached.variation();
}

double SiteRelaxation::variation() {
    return set_goals();
}

void SiteRelaxation::iterate(int passes, const std::stop_token& stop) {
    mesh_.restore_delaunay(stop);
    set_goals();
    const SiteOrder order(mesh_, [](std::uint32_t) { return true; });
    for (int pass = 0; pass < passes && !stop.stop_requested(); ++pass)
        order.for_sites([&](std::uint32_t site) { move(site); });
}

void SiteRelaxation::move(std::uint32_t site) {
    constexpr double kLeastArea = 0.1;  // share of a triangle's area that a move must leave
    Ring ring;
    if (!ring.gather(mesh_, site)) return;
    // The normal equations of the sum of (weight * doubled area - target)^2 / share, and of the springs. After a move
    // m, the doubled area is area - cross(m, edge).
    double xx = 0, xy = 0, yy = 0;
    Point right;
    for (std::size_t i = 0; i < ring.count; ++i) {
        const TriangleGoal& goal = goals_[ring.triangles[i]];
        const Point edge = ring.flat[i + 1] - ring.flat[i];
        const Point slope{-goal.weight * edge.y, goal.weight * edge.x};
        const double area = length(cross(ring.places[i], ring.places[i + 1]));
        const double rest = (goal.target - goal.weight * area) / goal.share;
        const double spring = kSpring * goal.weight * goal.share;
        xx += slope.x * slope.x / goal.share + spring;
        xy += slope.x * slope.y / goal.share;
        yy += slope.y * slope.y / goal.share + spring;
        right = right + rest * slope + spring * ring.flat[i];
    }
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 0)) return;
    Point move{(yy * right.x - xy * right.y) / determinant, (xx * right.y - xy * right.x) / determinant};
    move = kRelaxation * move;
    double share = 1;
    for (std::size_t i = 0; i < ring.count; ++i) {
        const double area = cross(ring.flat[i], ring.flat[i + 1]);
        const double lost = cross(move, ring.flat[i + 1] - ring.flat[i]), most = (1 - kLeastArea) * area;
        if (lost > most) share = std::min(share, std::max(0.0, most / lost));
    }
    move = share * move;
    mesh_.move(site, move.x * ring.x + move.y * ring.y);
}

}  // namespace ccdt
