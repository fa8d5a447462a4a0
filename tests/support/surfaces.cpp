// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/surfaces.h"

#include <algorithm>
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

constexpr std::uint32_t side_after(std::uint32_t edge, std::uint32_t count) {
    return edge / 4 * 4 + (edge % 4 + count) % 3;
}

std::uint32_t tail(const Surface& surface, std::uint32_t edge) {
    return surface.corners(edge / 4)[edge % 4];
}

bool is_unit(Point3 p) {
    return std::abs(length(p) - 1) < 1e-9;
}

std::string fault_at(const Surface& surface, std::uint32_t edge) {
    if (tail(surface, edge) >= surface.vertex_count()) return "a corner is not a vertex";
    if (tail(surface, edge) == tail(surface, side_after(edge, 1))) return "an edge is a loop";
    const std::uint32_t twin = surface.twin(edge);
    if (twin == Surface::kNone) return surface.is_crease(edge) ? "" : "a border edge does not count as a crease";
    if (surface.twin(twin) != edge) return "twins differ";
    if (surface.is_crease(twin) != surface.is_crease(edge)) return "an edge is a crease on one side only";
    if (tail(surface, twin) != tail(surface, side_after(edge, 1)) ||
        tail(surface, edge) != tail(surface, side_after(twin, 1))) {
        return "neighbours differ in orientation";
    }
    if (!surface.is_crease(edge) && surface.component(edge / 4) != surface.component(twin / 4)) {
        return "neighbours are in different components";
    }
    return "";
}

/// Returns the number of corners in the fan around a corner's vertex; more than `limit` if the fan does not end.
std::size_t fan_size(const Surface& surface, std::uint32_t corner, std::size_t limit) {
    std::size_t size = 0;
    std::uint32_t at = corner;
    do {
        ++size;
        at = surface.twin(side_after(at, 2));
    } while (at != Surface::kNone && at != corner && size <= limit);
    if (at == corner) return size;
    for (at = surface.twin(corner); at != Surface::kNone && size <= limit; ++size) {
        at = surface.twin(side_after(at, 1));
    }
    return size;
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

TriangleSoup bipyramid_surface(int sides, double height) {
    TriangleSoup soup;
    soup.vertices = {{0, 0, height}, {0, 0, -height}};
    const auto count = static_cast<std::uint32_t>(sides);
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto [cos, sin] = on_circle(static_cast<double>(i) / sides);
        soup.vertices.push_back({cos, sin, 0});
        const std::uint32_t a = 2 + i, b = 2 + (i + 1) % count;
        soup.triangles.insert(soup.triangles.end(), {{0, a, b}, {1, b, a}});
    }
    return soup;
}

TriangleSoup tetrahedron_surface() {
    return {.vertices = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
            .triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}

TriangleSoup divided(const TriangleSoup& soup, int count) {
    TriangleSoup parts;
    for (const auto& triangle : soup.triangles) {
        // The sum over the corners in the order of their positions does not depend on the triangle.
        auto corners = triangle;
        std::ranges::sort(corners, {}, [&](std::uint32_t v) {
            const Point3 p = soup.vertices[v];
            return std::array{p.x, p.y, p.z};
        });
        const auto vertex = [&](int i, int j) {
            const std::array<int, 3> weights{count - i - j, i, j};
            Point3 sum;
            for (const std::uint32_t v : corners) {
                const auto k = static_cast<std::size_t>(std::ranges::find(triangle, v) - triangle.begin());
                sum = sum + weights[k] * soup.vertices[v];
            }
            parts.vertices.push_back(1.0 / count * sum);
            return static_cast<std::uint32_t>(parts.vertices.size() - 1);
        };
        for (int i = 0; i < count; ++i) {
            for (int j = 0; i + j < count; ++j) {
                parts.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)});
                if (i + j + 1 == count) continue;
                parts.triangles.push_back({vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
            }
        }
    }
    return parts;
}

TriangleSoup renumbered(TriangleSoup soup, int turns) {
    std::ranges::reverse(soup.vertices);
    const auto last = static_cast<std::uint32_t>(soup.vertices.size() - 1);
    for (auto& triangle : soup.triangles) {
        std::rotate(triangle.begin(), triangle.begin() + turns, triangle.end());
        for (std::uint32_t& v : triangle) v = last - v;
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

TriangleSoup needle_prism(int sides) {
    const Point3 axis = std::sqrt(3.0) * Point3{1, 1, 1};
    const Point3 x = std::sqrt(0.125) * Point3{1, -1, 0}, y = std::sqrt(1.0 / 24) * Point3{1, 1, -2};
    TriangleSoup soup;
    soup.vertices = {{}, axis};
    const auto count = static_cast<std::uint32_t>(sides);
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto [cos, sin] = on_circle(static_cast<double>(i) / sides);
        const Point3 corner = cos * x + sin * y;
        soup.vertices.insert(soup.vertices.end(), {corner, corner + axis});
        const std::uint32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % count);
        soup.triangles.insert(soup.triangles.end(), {{0, a, b}, {1, b + 1, a + 1}, {a, b + 1, b}, {a, a + 1, b + 1}});
    }
    return soup;
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

std::string fault_in(const Surface& surface) {
    std::vector<std::size_t> corners_at(surface.vertex_count());
    double area = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        if (!is_unit(surface.normal(f))) return "a normal does not have unit length";
        if (surface.component(f) >= surface.component_count()) return "a component has a wrong number";
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (std::string fault = fault_at(surface, 4 * f + k); !fault.empty()) return fault;
            ++corners_at[surface.corners(f)[k]];
        }
        area += surface.area(f);
    }
    if (!(area > 0) || std::abs(area - surface.total_area()) > 1e-9 * area) return "the total area is wrong";
    for (std::uint32_t corner = 0; corner < 4 * surface.face_count(); ++corner) {
        if (corner % 4 == 3) continue;
        const std::size_t count = corners_at[tail(surface, corner)];
        if (fan_size(surface, corner, count) != count) return "a vertex has several fans";
    }
    for (std::uint32_t v = 0; v < surface.vertex_count(); ++v) {
        const Point3 p = surface.vertex(v);
        if (!is_unit(surface.vertex_normal(v))) return "the normal of a vertex does not have unit length";
        if (!(std::min({p.x, p.y, p.z}) >= 0 && std::max({p.x, p.y, p.z}) <= 1)) return "a vertex is out of range";
    }
    return "";
}

bool is_on(const SurfacePoint& point, const Surface& surface) {
    const auto& [a, b, c] = point.weights;
    return point.face < surface.face_count() && a >= 0 && b >= 0 && c >= 0 && std::abs(a + b + c - 1) < 1e-12;
}

}  // namespace ccdt::test
