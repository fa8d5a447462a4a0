// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/surfaces.h"

#include <cmath>
#include <numbers>

namespace ccdt::test {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// Returns a position on a circle. Both ends of the circle have exactly the same position.
std::array<double, 2> on_circle(double share) {
    const double angle = kTurn * (share == 1 ? 0 : share);
    return {std::cos(angle), std::sin(angle)};
}

Point3 on_sphere(Point3 p) {
    return 1 / length(p) * p;
}

}  // namespace

TriangleSoup grid_surface(int columns, int rows, const std::function<Point3(double, double)>& position) {
    TriangleSoup soup;
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i <= columns; ++i) {
            soup.vertices.push_back(position(static_cast<double>(i) / columns, static_cast<double>(j) / rows));
        }
    }
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i);
            const auto c = static_cast<std::uint32_t>(a + static_cast<std::uint32_t>(columns) + 2);
            soup.triangles.push_back({a, a + 1, c});
            soup.triangles.push_back({a, c, c - 1});
        }
    }
    return soup;
}

TriangleSoup square_surface(int cells) {
    return grid_surface(cells, cells, [](double u, double v) { return Point3{u, v, 0}; });
}

TriangleSoup cube_surface(Point3 corner, double side) {
    TriangleSoup soup;
    for (int i = 0; i < 8; ++i) {
        const Point3 p{static_cast<double>(i & 1), static_cast<double>(i >> 1 & 1), static_cast<double>(i >> 2)};
        soup.vertices.push_back(corner + side * p);
    }
    soup.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return soup;
}

TriangleSoup sphere_surface(int levels) {
    const double g = std::numbers::phi;
    TriangleSoup soup{.vertices = {{-1, g, 0},
                                   {1, g, 0},
                                   {-1, -g, 0},
                                   {1, -g, 0},
                                   {0, -1, g},
                                   {0, 1, g},
                                   {0, -1, -g},
                                   {0, 1, -g},
                                   {g, 0, -1},
                                   {g, 0, 1},
                                   {-g, 0, -1},
                                   {-g, 0, 1}},
                      .triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
    for (Point3& p : soup.vertices) p = on_sphere(p);
    for (int level = 0; level < levels; ++level) {
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (const auto& [a, b, c] : soup.triangles) {
            const auto middle = [&soup](std::uint32_t i, std::uint32_t j) {
                // The sum does not depend on the order, so that neighbours have exactly the same middle.
                soup.vertices.push_back(on_sphere(soup.vertices[i] + soup.vertices[j]));
                return static_cast<std::uint32_t>(soup.vertices.size() - 1);
            };
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            triangles.insert(triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        soup.triangles = std::move(triangles);
    }
    return soup;
}

TriangleSoup torus_surface(double major, double minor, int columns, int rows) {
    return grid_surface(columns, rows, [=](double u, double v) {
        const auto [cos_u, sin_u] = on_circle(u);
        const auto [cos_v, sin_v] = on_circle(v);
        const double radius = major + minor * cos_v;
        return Point3{radius * cos_u, radius * sin_u, minor * sin_v};
    });
}

TriangleSoup moebius_strip(int columns, int rows) {
    return grid_surface(columns, rows, [](double u, double v) {
        // The last column is the first one, upside down.
        const bool is_last = u == 1;
        const double across = (is_last ? 1 - v : v) - 0.5;
        const double angle = is_last ? 0 : kTurn * u;
        const double radius = 1 + across * std::cos(angle / 2);
        return Point3{radius * std::cos(angle), radius * std::sin(angle), across * std::sin(angle / 2)};
    });
}

TriangleSoup joined(TriangleSoup a, const TriangleSoup& b) {
    const auto offset = static_cast<std::uint32_t>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({i + offset, j + offset, k + offset});
    return a;
}

}  // namespace ccdt::test
