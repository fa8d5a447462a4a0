// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/odt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace ccdt {
namespace {

/// Returns the shortest vector between two corners on the unit torus.
Point offset_of(Point from, Point to) {
    const Point d = to - from;
    return {d.x - std::round(d.x), d.y - std::round(d.y)};
}

double doubled_area(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
    return cross(offset_of(mesh.vertices[t[0]], mesh.vertices[t[1]]),
                 offset_of(mesh.vertices[t[0]], mesh.vertices[t[2]]));
}

/// Returns the integrated error of the piecewise linear interpolation of |x|^2. Each triangle adds a twelfth of its
/// area times the sum of its squared edges.
double interpolation_error(const TriangleMesh& mesh) {
    double error = 0;
    for (const auto& t : mesh.triangles) {
        double edges = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const Point edge = offset_of(mesh.vertices[t[i]], mesh.vertices[t[(i + 1) % 3]]);
            edges += dot(edge, edge);
        }
        error += doubled_area(mesh, t) * edges / 24;
    }
    return error;
}

TriangleMesh mesh_after(int iterations, std::size_t sites) {
    return odt(Domain::torus(1, 1).value(), Density::uniform(),
               {.sites = sites, .seed = 1, .iterations = iterations, .keep_mesh = true})
        ->mesh.value();
}

TEST(Odt, LowersTheInterpolationErrorInEveryIteration) {
    double before = std::numeric_limits<double>::infinity();
    for (int iterations = 0; iterations < 30; ++iterations) {
        const double now = interpolation_error(mesh_after(iterations, 300));
        EXPECT_LT(now, before) << iterations;
        before = now;
    }
    // The error per area of equilateral triangles is 1 / (2 sqrt 3) times the area of two of them.
    EXPECT_GT(before, 0.28868 / 300);
    EXPECT_LT(before, 0.28868 / 300 * 1.1);
}

Point circumcentre(Point p, Point q) {
    const double d = 2 * cross(p, q);
    return {(q.y * dot(p, p) - p.y * dot(q, q)) / d, (p.x * dot(q, q) - q.x * dot(p, p)) / d};
}

TEST(Odt, MovesSitesToTheMeanCircumcentre) {
    const TriangleMesh mesh = mesh_after(1000, 50);
    std::vector<Point> moments(50);
    std::vector<double> areas(50, 0);
    for (const auto& t : mesh.triangles) {
        const double area = doubled_area(mesh, t);
        for (std::size_t i = 0; i < 3; ++i) {
            const Point at = mesh.vertices[t[i]];
            const Point centre = circumcentre(offset_of(at, mesh.vertices[t[(i + 1) % 3]]),
                                              offset_of(at, mesh.vertices[t[(i + 2) % 3]]));
            moments[t[i]] = moments[t[i]] + area * centre;
            areas[t[i]] += area;
        }
    }
    for (std::size_t i = 0; i < 50; ++i) EXPECT_LT(std::hypot(moments[i].x, moments[i].y) / areas[i], 1e-6) << i;
}

TEST(Odt, Converges) {
    const auto result = odt(Domain::rectangle(1, 1).value(), Density::uniform(), {.sites = 10, .iterations = 1000});
    EXPECT_LT(result->iterations, 1000);
}

/// A strip of two spacings along the border holds its share of sites, because the first row is half a row inside.
TEST(Odt, KeepsTheDensityAlongTheBorder) {
    const Domain square = Domain::rectangle(1, 1).value();
    double near = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        const auto result = odt(square, Density::uniform(), {.sites = 2500, .seed = seed, .iterations = 60});
        for (const Point& p : result->points) {
            near += std::min({p.x, p.y, 1 - p.x, 1 - p.y}) < 2.0 / 50 ? 1.0 / 2500 / 4 : 0;
        }
    }
    EXPECT_NEAR(near / (1 - 0.92 * 0.92), 1, 0.06);
}

}  // namespace
}  // namespace ccdt
