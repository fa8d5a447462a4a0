// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/shape_checks.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "core/geometry/delaunay.h"
#include "tests/fuzz/checks.h"
#include "tests/support/shapes.h"

namespace ccdt::fuzz {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

double doubled_area(const Ring& ring) {
    double sum = 0;
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) sum += cross(ring[i] - ring[0], ring[i + 1] - ring[0]);
    return sum;
}

double length(Point p) {
    return std::sqrt(dot(p, p));
}

bool is_within(const Box& box, Point p) {
    return p.x >= box.min.x && p.x <= box.max.x && p.y >= box.min.y && p.y <= box.max.y;
}

/// Whether a triangle is counter-clockwise, or as flat as the rounding of the domain's coordinates can make it.
bool is_sound(Point a, Point b, Point c, const Domain& domain) {
    if (exact_orientation(a, b, c) > 0) return true;
    const double shift = domain.resolution() * std::max(domain.bounds().width(), domain.bounds().height());
    const double around = length(b - a) + length(c - b) + length(a - c);
    return std::abs(cross(b - a, c - a)) <= shift * around;
}

/// Checks that every triangle is sound, that no edge has more than two triangles, that the edges with one triangle form
/// the boundary, and that the triangles cover the area of the domain.
void check_mesh(const TriangleMesh& mesh, const Domain& domain) {
    std::map<Edge, int> edges;
    double area = 0;
    for (const auto& corners : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            CCDT_CHECK(corners[i] < mesh.vertices.size());
            CCDT_CHECK(++edges[Edge(corners[i], corners[(i + 1) % 3])] == 1);
        }
        const Point a = mesh.vertices[corners[0]], b = mesh.vertices[corners[1]], c = mesh.vertices[corners[2]];
        CCDT_CHECK(is_sound(a, b, c, domain));
        area += cross(b - a, c - a) / 2;
    }
    std::size_t alone = 0;
    for (const auto& [edge, count] : edges) {
        if (!edges.contains({edge.second, edge.first})) ++alone;
    }
    std::size_t boundary = 0;
    for (const auto& loop : mesh.boundary) {
        boundary += loop.size();
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Edge edge{loop[i], loop[(i + 1) % loop.size()]};
            CCDT_CHECK(edges.contains(edge) && !edges.contains({edge.second, edge.first}));
        }
    }
    CCDT_CHECK(alone == boundary);
    CCDT_CHECK(std::abs(area - domain.area()) <= 1e-3 * domain.area());
}

}  // namespace

void check_domain(const Domain& domain) {
    constexpr double kLittle = 1e-12;
    const Box unit = domain.unit_bounds();
    CCDT_CHECK(unit.min == Point{});
    CCDT_CHECK(unit.max.x > 0 && unit.max.y > 0 && std::max(unit.max.x, unit.max.y) == 1);
    CCDT_CHECK(domain.unit_area() > 0 && domain.unit_area() <= unit.width() * unit.height() * (1 + kLittle));
    CCDT_CHECK(std::isfinite(domain.area()));
    CCDT_CHECK(domain.is_torus() == domain.rings().empty());
    double doubled = 0;
    for (const Ring& ring : domain.rings()) {
        CCDT_CHECK(ring.size() >= 3);
        for (const Point& p : ring) CCDT_CHECK(is_within(unit, p));
        doubled += doubled_area(ring);
    }
    CCDT_CHECK(domain.is_torus() || std::abs(doubled / 2 - domain.unit_area()) < 1e-9);
}

void check_soup(const TriangleSoup& soup) {
    const std::size_t vertices = soup.vertices.size();
    CCDT_CHECK(!soup.triangles.empty());
    CCDT_CHECK(soup.colours.empty() || soup.colours.size() == vertices);
    CCDT_CHECK(soup.texture.empty() || soup.texture.size() == vertices);
    CCDT_CHECK(soup.material_of.size() == (soup.materials.empty() ? 0 : soup.triangles.size()));
    for (const auto& triangle : soup.triangles) CCDT_CHECK(std::ranges::max(triangle) < vertices);
    for (std::uint32_t t = 0; t < soup.triangles.size() && soup.colours.empty(); ++t) {
        for (const float share : soup.colour_at(t, {0.5, 0.25, 0.25})) CCDT_CHECK(share >= 0 && share <= 1);
    }
}

void check_cover(const Domain& domain, const std::vector<PolygonPart>& parts) {
    constexpr int kProbes = 12;
    constexpr double kNear = 1e-9;
    const Box& box = domain.bounds();
    const double scale = std::max(box.width(), box.height());
    for (int i = 0; i < kProbes * kProbes; ++i) {
        const Point unit{(i % kProbes + 0.37) / kProbes * box.width() / scale,
                         (i / kProbes + 0.61) / kProbes * box.height() / scale};
        if (test::distance_to_border(parts, domain.to_user(unit)) < kNear * scale) continue;
        bool is_inside = false;
        for (const Ring& ring : domain.rings()) is_inside ^= test::contains({{ring, {}}}, unit);
        CCDT_CHECK(is_inside == test::contains(parts, domain.to_user(unit)));
    }
}

void check_location(const Error& error, const std::vector<PolygonPart>& parts) {
    check_error(error);
    CCDT_CHECK(error.code == ErrorCode::Unusable);
    check_location(Repair{error.field, error.message}, parts);
}

void check_location(const Repair& repair, const std::vector<PolygonPart>& parts) {
    CCDT_CHECK(!repair.detail.empty());
    std::vector<std::size_t> indices;
    for (std::string_view rest = repair.field; !rest.empty();) {
        CCDT_CHECK(rest.front() == '/');
        std::size_t index = 0;
        const auto [end, wrong] = std::from_chars(rest.data() + 1, rest.data() + rest.size(), index);
        CCDT_CHECK(wrong == std::errc());
        rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
        indices.push_back(index);
    }
    CCDT_CHECK(indices.size() <= 3);
    if (indices.empty()) return;
    CCDT_CHECK(indices[0] < parts.size());
    if (indices.size() < 2) return;
    const PolygonPart& part = parts[indices[0]];
    CCDT_CHECK(indices[1] <= part.holes.size());
    const Ring& ring = indices[1] == 0 ? part.outer : part.holes[indices[1] - 1];
    CCDT_CHECK(indices.size() < 3 || indices[2] < ring.size());
}

void check_points(const std::vector<Point>& points, std::size_t sites, const Domain& domain,
                  const std::vector<PolygonPart>& parts) {
    CCDT_CHECK(points.size() == sites);
    for (const Point& p : points) {
        CCDT_CHECK(is_within(domain.bounds(), p));
        CCDT_CHECK(parts.empty() || test::contains(parts, p));
    }
    CCDT_CHECK(test::count_distinct(points) == points.size());
}

void check_distribution(const Domain& domain, const std::vector<PolygonPart>& parts, const Density& density,
                        Options options) {
    options.keep_mesh = true;
    const auto distribution = distribute(domain, density, options);
    if (!distribution) {
        check_error(distribution.error());
        CCDT_CHECK(distribution.error().code == ErrorCode::Unusable);
        return;
    }
    CCDT_CHECK(!distribution->stopped);
    CCDT_CHECK(distribution->iterations <= options.iterations);
    CCDT_CHECK(distribution->trace.size() == static_cast<std::size_t>(distribution->iterations) + 1);
    CCDT_CHECK(std::isfinite(distribution->variation()) && distribution->variation() >= 0);
    check_points(distribution->points, options.sites, domain, parts);
    if (!domain.is_torus()) check_mesh(*distribution->mesh, domain);

    const auto again = distribute(domain, density, options);
    CCDT_CHECK(again && again->points == distribution->points && again->trace == distribution->trace);
}

}  // namespace ccdt::fuzz
