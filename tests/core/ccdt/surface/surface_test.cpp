// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <stop_token>

#include "core/base/random.h"
#include "core/ccdt/surface/unfolding.h"
#include "tests/support/surfaces.h"

namespace ccdt {
namespace {

using test::cube_surface;
using test::joined;
using test::square_surface;

constexpr double kPi = std::numbers::pi;

Surface::Made made(const TriangleSoup& soup, std::optional<double> crease = {}) {
    auto result = Surface::create(soup, crease);
    EXPECT_TRUE(result) << result.error().message;
    return *std::move(result);
}

/// Returns the number of occurrences of a repair whose text contains a word; 0 if there is none.
std::size_t repairs(const Surface::Made& made, const std::string& word) {
    for (const SurfaceNote& note : made.repairs) {
        if (note.detail.find(word) != std::string::npos) return note.count;
    }
    return 0;
}

double area(const Surface& surface) {
    return surface.total_area() * surface.scale() * surface.scale();
}

/// Returns the volume that a surface encloses, in the unit frame.
double volume(const Surface& surface) {
    double sum = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto [a, b, c] = surface.positions(f);
        sum += dot(a, cross(b, c)) / 6;
    }
    return sum;
}

std::size_t border_edges(const Surface& surface) {
    std::size_t count = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        for (std::uint32_t k = 0; k < 3; ++k) count += surface.twin(4 * f + k) == Surface::kNone;
    }
    return count;
}

std::ptrdiff_t euler_characteristic(const Surface& surface) {
    const std::size_t edges = (3 * surface.face_count() + border_edges(surface)) / 2;
    return static_cast<std::ptrdiff_t>(surface.vertex_count() + surface.face_count()) -
           static_cast<std::ptrdiff_t>(edges);
}

void expect_inside(const SurfacePoint& point, const Surface& surface) {
    EXPECT_TRUE(test::is_on(point, surface))
        << point.face << ": " << point.weights[0] << ' ' << point.weights[1] << ' ' << point.weights[2];
}

void expect_near(Point3 a, Point3 b, double tolerance) {
    EXPECT_LT(length(a - b), tolerance) << '(' << a.x << ' ' << a.y << ' ' << a.z << ") is not (" << b.x << ' ' << b.y
                                        << ' ' << b.z << ')';
}

void expect_valid(const Surface& surface) {
    EXPECT_EQ(test::fault_in(surface), "");
}

TEST(Surface, KeepsACube) {
    const auto cube = made(cube_surface({1, 2, 3}, 4));
    const Surface& surface = cube.surface;
    expect_valid(surface);
    EXPECT_TRUE(cube.repairs.empty());
    EXPECT_TRUE(cube.warnings.empty());
    EXPECT_EQ(surface.vertex_count(), 8U);
    EXPECT_EQ(surface.face_count(), 12U);
    EXPECT_EQ(border_edges(surface), 0U);
    EXPECT_EQ(surface.component_count(), 1U);
    EXPECT_DOUBLE_EQ(area(surface), 6 * 16);
    EXPECT_DOUBLE_EQ(volume(surface), 1);
    EXPECT_EQ(surface.scale(), 4);
    expect_near(surface.to_input({0.5, 0.25, 1}), {3, 3, 7}, 1e-12);
    expect_near(surface.from_input({3, 3, 7}), {0.5, 0.25, 1}, 1e-12);
    for (std::uint32_t v = 0; v < 8; ++v) {
        const Point3 outward = surface.vertex(v) - Point3{0.5, 0.5, 0.5};
        expect_near(surface.vertex_normal(v), 1 / length(outward) * outward, 1e-12);
    }
}

TEST(Surface, SeparatesTheSidesOfACubeByCreases) {
    const Surface surface = made(cube_surface(), kPi / 4).surface;
    expect_valid(surface);
    EXPECT_EQ(surface.component_count(), 6U);
    EXPECT_EQ(made(cube_surface(), 1.1 * kPi / 2).surface.component_count(), 1U);
}

TEST(Surface, ClosesGridsByMergingVertices) {
    const auto torus = made(test::torus_surface(2, 0.5, 200, 100));
    expect_valid(torus.surface);
    EXPECT_TRUE(torus.repairs.empty());
    EXPECT_EQ(border_edges(torus.surface), 0U);
    EXPECT_EQ(euler_characteristic(torus.surface), 0);
    EXPECT_NEAR(area(torus.surface), 4 * kPi * kPi * 2 * 0.5, 0.02);
    EXPECT_GT(volume(torus.surface), 0);

    const auto sphere = made(test::sphere_surface(4));
    expect_valid(sphere.surface);
    EXPECT_EQ(euler_characteristic(sphere.surface), 2);
    EXPECT_NEAR(area(sphere.surface), 4 * kPi, 0.03);
    for (std::uint32_t v = 0; v < sphere.surface.vertex_count(); ++v) {
        expect_near(sphere.surface.vertex_normal(v), sphere.surface.to_input(sphere.surface.vertex(v)), 0.005);
    }
}

TEST(Surface, CutsAMoebiusStrip) {
    const auto strip = made(test::moebius_strip(40, 4));
    expect_valid(strip.surface);
    EXPECT_EQ(repairs(strip, "one side"), 4U);
    EXPECT_EQ(euler_characteristic(strip.surface), 1);  // a disk
}

TEST(Surface, RemovesRepeatedTriangles) {
    TriangleSoup soup = cube_surface();
    soup.triangles.push_back(soup.triangles[3]);
    soup.triangles.push_back({soup.triangles[4][1], soup.triangles[4][0], soup.triangles[4][2]});
    const auto cube = made(soup);
    expect_valid(cube.surface);
    ASSERT_EQ(cube.repairs.size(), 1U);
    EXPECT_EQ(cube.repairs[0].detail, "2 repeated triangles were removed");
    EXPECT_EQ(cube.repairs[0].count, 2U);
    EXPECT_EQ(cube.repairs[0].triangle, 12U);
    EXPECT_EQ(border_edges(cube.surface), 0U);
}

TEST(Surface, TurnsTrianglesOver) {
    TriangleSoup soup = cube_surface();
    for (const std::size_t t : {2U, 7U, 8U, 11U}) std::swap(soup.triangles[t][0], soup.triangles[t][2]);
    const auto cube = made(soup);
    expect_valid(cube.surface);
    EXPECT_DOUBLE_EQ(volume(cube.surface), 1);
    ASSERT_EQ(cube.repairs.size(), 1U);
    EXPECT_EQ(cube.repairs[0].detail, "4 triangles were turned over");
    EXPECT_EQ(cube.repairs[0].triangle, 2U);
    for (std::uint32_t f = 0; f < 12; ++f) {
        const SurfacePoint point{f, {0.5, 0.3, 0.2}};
        const auto weights = cube.surface.original_weights(point);
        Point3 p;
        for (std::size_t k = 0; k < 3; ++k) {
            p = p + weights[k] * soup.vertices[soup.triangles[cube.surface.triangle_of(f)][k]];
        }
        expect_near(p, cube.surface.position(point), 1e-12);
    }
    for (auto& [a, b, c] : soup.triangles) std::swap(a, b);
    EXPECT_DOUBLE_EQ(volume(made(soup).surface), 1);
}

TEST(Surface, TurnsTheMinorityOfTheTrianglesOfAnOpenSurface) {
    TriangleSoup soup = square_surface(3);
    std::swap(soup.triangles[0][0], soup.triangles[0][1]);
    const auto square = made(soup);
    expect_valid(square.surface);
    EXPECT_EQ(repairs(square, "turned"), 1U);
    expect_near(square.surface.normal(0), {0, 0, 1}, 1e-12);
    for (auto& [a, b, c] : soup.triangles) std::swap(a, b);
    EXPECT_EQ(repairs(made(soup), "turned"), 1U);
}

TEST(Surface, KeepsCavities) {
    const auto turned = [](TriangleSoup soup) {
        for (auto& [a, b, c] : soup.triangles) std::swap(a, b);
        return soup;
    };
    const TriangleSoup outer = cube_surface({}, 4), inner = cube_surface({1, 1, 1}, 2),
                       core = cube_surface({1.5, 1.5, 1.5});
    const auto volume_in = [](const Surface::Made& made) {
        expect_valid(made.surface);
        return volume(made.surface) * std::pow(made.surface.scale(), 3);
    };
    const auto hollow = made(joined(outer, turned(inner)));
    EXPECT_NEAR(volume_in(hollow), 64 - 8, 1e-9);
    EXPECT_TRUE(hollow.repairs.empty());
    const auto nested = made(joined(joined(turned(inner), outer), core));
    EXPECT_NEAR(volume_in(nested), 64 - 8 + 1, 1e-9);
    EXPECT_TRUE(nested.repairs.empty());
    const auto bodies = made(joined(outer, inner));  // of an assembly
    EXPECT_NEAR(volume_in(bodies), 64 + 8, 1e-9);
    EXPECT_TRUE(bodies.repairs.empty());
    const auto inside_out = made(joined(joined(turned(outer), inner), turned(core)));
    EXPECT_NEAR(volume_in(inside_out), 64 - 8 + 1, 1e-9);
    EXPECT_EQ(repairs(inside_out, "turned"), 36U);
    // A cube beside another one is not a cavity.
    const auto beside = made(joined(outer, turned(cube_surface({5, 1, 1}, 2))));
    EXPECT_NEAR(volume_in(beside), 64 + 8, 1e-8);
    EXPECT_EQ(repairs(beside, "turned"), 12U);
    TriangleSoup damaged = joined(outer, turned(inner));
    std::swap(damaged.triangles[14][0], damaged.triangles[14][1]);
    const auto repaired = made(damaged);
    EXPECT_NEAR(volume_in(repaired), 64 - 8, 1e-9);
    EXPECT_EQ(repairs(repaired, "turned"), 1U);
}

TEST(Surface, KeepsManyCavities) {
    TriangleSoup soup = cube_surface({-1, -1, -1}, 22);
    for (int i = 0; i < 1000; ++i) {
        TriangleSoup cavity = cube_surface({2.0 * (i % 10), 2.0 * (i / 10 % 10), 2.0 * (i / 100)});
        for (auto& [a, b, c] : cavity.triangles) std::swap(a, b);
        soup = joined(std::move(soup), cavity);
    }
    const auto foam = made(soup);
    EXPECT_TRUE(foam.repairs.empty());
    EXPECT_NEAR(volume(foam.surface) * std::pow(22, 3), std::pow(22, 3) - 1000, 1e-6);
}

TEST(Surface, RemovesWallsBetweenParts) {
    // Two cubes with a common face, whose two sides are divided along different diagonals or along the same one.
    TriangleSoup left = cube_surface(), right = cube_surface({1, 0, 0});
    const auto is_on_wall = [](const TriangleSoup& soup, const auto& triangle) {
        return std::ranges::all_of(triangle, [&](std::uint32_t v) { return soup.vertices[v].x == 1; });
    };
    TriangleSoup mirrored = left;
    for (Point3& p : mirrored.vertices) p.x = 2 - p.x;
    for (auto& [a, b, c] : mirrored.triangles) std::swap(a, b);
    for (const TriangleSoup& other : {right, mirrored}) {
        const TriangleSoup soup = joined(left, other);
        const auto walls = std::ranges::count_if(soup.triangles, [&](const auto& t) { return is_on_wall(soup, t); });
        const auto boxes = made(soup);
        expect_valid(boxes.surface);
        ASSERT_EQ(walls, 4);
        ASSERT_EQ(boxes.repairs.size(), 1U);
        EXPECT_EQ(boxes.repairs[0].detail, "4 triangles of walls between two parts were removed");
        EXPECT_EQ(boxes.surface.component_count(), 1U);
        EXPECT_EQ(border_edges(boxes.surface), 0U);
        EXPECT_DOUBLE_EQ(area(boxes.surface), 10);
        EXPECT_DOUBLE_EQ(volume(boxes.surface) * 8, 2);
    }
    // Eight cubes that fill a larger one.
    TriangleSoup eight;
    for (int i = 0; i < 8; ++i)
        eight = joined(std::move(eight), cube_surface({i % 2 * 1.0, i / 2 % 2 * 1.0, i / 4 * 1.0}));
    const auto cube = made(eight);
    expect_valid(cube.surface);
    EXPECT_DOUBLE_EQ(area(cube.surface), 24);
    EXPECT_EQ(border_edges(cube.surface), 0U);
}

TEST(Surface, KeepsOneSideOfASheet) {
    const auto two_sided = [](TriangleSoup soup) {
        TriangleSoup back = soup;
        for (auto& [a, b, c] : back.triangles) std::swap(a, b);
        return joined(std::move(soup), back);
    };
    for (const int cells : {1, 2, 5}) {
        const auto sheet = made(two_sided(square_surface(cells)));
        expect_valid(sheet.surface);
        EXPECT_DOUBLE_EQ(area(sheet.surface), 1) << cells;
        EXPECT_EQ(sheet.surface.component_count(), 1U);
        EXPECT_EQ(repairs(sheet, "repeated"), 2U * static_cast<unsigned>(cells * cells));
    }
    const auto sphere = made(two_sided(test::sphere_surface(2)));
    EXPECT_EQ(border_edges(sphere.surface), 0U);
    EXPECT_EQ(repairs(sphere, "repeated"), sphere.surface.face_count());
    // A fin on a cube is not a wall.
    TriangleSoup fin{.vertices = {{1, 0, 0}, {1, 0, 1}, {2, 0, 1}, {2, 0, 0}}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
    const auto body = made(joined(cube_surface(), two_sided(fin)));
    EXPECT_DOUBLE_EQ(area(body.surface), 7);
    EXPECT_EQ(repairs(body, "walls"), 0U);
}

TEST(Surface, SeparatesCubesThatShareAnEdgeOrAVertex) {
    const auto edge = made(joined(cube_surface(), cube_surface({1, 1, 0})));
    expect_valid(edge.surface);
    EXPECT_EQ(edge.surface.component_count(), 2U);
    EXPECT_EQ(border_edges(edge.surface), 0U);
    EXPECT_EQ(euler_characteristic(edge.surface), 4);
    ASSERT_EQ(edge.repairs.size(), 1U);
    EXPECT_EQ(edge.repairs[0].detail, "the surface was cut along 1 edge where it only touches itself");

    const auto vertex = made(joined(cube_surface(), cube_surface({1, 1, 1})));
    expect_valid(vertex.surface);
    EXPECT_EQ(vertex.surface.vertex_count(), 16U);
    ASSERT_EQ(vertex.repairs.size(), 1U);
    EXPECT_EQ(vertex.repairs[0].detail, "the surface was cut at 1 vertex where it only touches itself");
}

TEST(Surface, CutsEdgesOfThreeTriangles) {
    TriangleSoup soup{.vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}},
                      .triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
    const auto fan = made(soup);
    expect_valid(fan.surface);
    EXPECT_EQ(fan.surface.component_count(), 3U);
    EXPECT_EQ(fan.surface.vertex_count(), 9U);
    ASSERT_EQ(fan.repairs.size(), 1U);
    EXPECT_EQ(fan.repairs[0].detail, "the surface was cut along 1 edge that more than two triangles share");
    EXPECT_EQ(fan.repairs[0].triangle, 0U);
}

/// A square of two triangles that are connected by a triangle without area.
TriangleSoup square_with_a_cap() {
    return {.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}},
            .triangles = {{0, 1, 4}, {1, 2, 4}, {0, 4, 2}, {0, 2, 3}}};
}

TEST(Surface, HasNoCracksAtTrianglesWithoutArea) {
    const auto square = made(square_with_a_cap());
    expect_valid(square.surface);
    EXPECT_TRUE(square.repairs.empty());
    EXPECT_EQ(border_edges(square.surface), 4U);
    EXPECT_DOUBLE_EQ(square.surface.total_area(), 1);
    expect_near(square.surface.normal(2), {0, 0, 1}, 1e-12);
    EXPECT_EQ(made(square_with_a_cap(), 0.1).surface.component_count(), 1U);
    for (const double share : {0.1, 0.3, 0.5, 0.6}) {
        const SurfacePoint start{0, {0.8 - share, share, 0.2}};
        const Point3 p = square.surface.position(start), move{-0.1, 0.3 + share, 0};
        const SurfacePoint end = square.surface.trace(start, move);
        expect_near(square.surface.position(end), p + move, 1e-9);
    }
}

TEST(Surface, RemovesTrianglesWithCoincidentCorners) {
    TriangleSoup soup = square_surface(2);
    // Two triangles have a side of length 0, between two vertices at the same position.
    soup.vertices[4] = soup.vertices[5];
    const auto square = made(soup);
    expect_valid(square.surface);
    EXPECT_EQ(square.surface.face_count(), 6U);
    ASSERT_FALSE(square.repairs.empty());
    EXPECT_EQ(square.repairs[0].detail, "2 triangles with coincident corners were removed");
    EXPECT_EQ(square.repairs[0].triangle, 3U);
}

TEST(Surface, RemovesComponentsWithoutArea) {
    TriangleSoup needle{.vertices = {{2, 2, 2}, {3, 3, 3}, {4, 4, 4}}, .triangles = {{0, 1, 2}}};
    const auto square = made(joined(needle, square_surface(1)));
    EXPECT_EQ(square.surface.face_count(), 2U);
    ASSERT_EQ(square.repairs.size(), 1U);
    EXPECT_EQ(square.repairs[0].detail, "1 triangle without area was removed");
    EXPECT_EQ(square.repairs[0].triangle, 0U);
    EXPECT_EQ(square.surface.triangle_of(0), 1U);
}

TEST(Surface, RejectsUnusableTriangles) {
    const double huge = std::numeric_limits<double>::max(), nan = std::numeric_limits<double>::quiet_NaN();
    const auto error = [](std::vector<Point3> vertices) {
        TriangleSoup soup{.vertices = std::move(vertices), .triangles = {}};
        if (!soup.vertices.empty()) soup.triangles = {{0, 1, 2}};
        const auto surface = Surface::create(soup, {});
        return surface ? Error{} : surface.error();
    };
    EXPECT_EQ(error({}).message, "there are no triangles");
    EXPECT_EQ(error({{}, {}, {}}).message, "no triangle has an area");
    EXPECT_EQ(error({{0, 0, 0}, {1, 1, 0}, {3, 3, 0}}).message, "no triangle has an area");
    EXPECT_EQ(error({{0, 0, 0}, {1, 1, nan}, {3, 4, 0}}).field, "vertices/1");
    EXPECT_EQ(error({{0, 0, 0}, {1, 1, 0}, {3, -2 * huge, 0}}).field, "vertices/2");
    EXPECT_EQ(error({{-huge, 0, 0}, {huge, 1, 0}, {3, 4, 0}}).code, ErrorCode::Unusable);
    EXPECT_EQ(error({{0, 0, 0}, {1e-308, 0, 0}, {0, 1e-308, 0}}).code, ErrorCode::Unusable);
    EXPECT_EQ(error({{1e12, 0, 0}, {1e12 + 1, 0, 0}, {1e12, 1, 0}}).code, ErrorCode::Unusable);
    // Vertices that no triangle uses do not count.
    EXPECT_EQ(error({{0, 0, 0}, {1, 1, 0}, {3, 4, 0}, {nan, huge, -huge}}).message, "");
}

TEST(Surface, AcceptsExtentsNearTheLimits) {
    for (const double scale : {1e-130, 1e130}) {
        const Surface surface = made(cube_surface({-scale, scale, 0}, scale)).surface;
        expect_valid(surface);
        EXPECT_DOUBLE_EQ(surface.total_area(), 6);
        expect_near(1 / scale * surface.to_input({1, 0.5, 0}), {0, 1.5, 0}, 1e-12);
    }
}

TEST(Surface, Stops) {
    std::stop_source source;
    source.request_stop();
    const auto surface = Surface::create(cube_surface(), {}, source.get_token());
    ASSERT_FALSE(surface);
    EXPECT_EQ(surface.error().code, ErrorCode::Stopped);
}

TEST(Surface, EndsTracesAtBordersAndCreases) {
    const Surface square = made(square_surface(5)).surface;
    const SurfacePoint start{20, {0.2, 0.3, 0.5}};
    const Point3 p = square.position(start);
    for (const Point3 move : {Point3{2, 0.3, 0}, {-3, 1, 0}, {0, 7, 9}, {0.1, -1e300, 0}}) {
        const SurfacePoint end = square.trace(start, move);
        expect_inside(end, square);
        const Point3 q = square.position(end);
        EXPECT_LT(std::min({q.x, q.y, 1 - q.x, 1 - q.y}), 1e-8);
        EXPECT_GT(std::min({q.x, q.y, 1 - q.x, 1 - q.y}), 0);
        EXPECT_NEAR((q.x - p.x) * move.y, (q.y - p.y) * move.x, 1e-8 * std::abs(move.y));
    }
    const Surface cube = made(cube_surface(), 1).surface;
    for (std::uint32_t f = 0; f < cube.face_count(); ++f) {
        const SurfacePoint end = cube.trace({f, {0.2, 0.3, 0.5}}, {3, 4, 5});
        EXPECT_EQ(cube.component(end.face), cube.component(f));
    }
}

TEST(Surface, IgnoresMovesThatAreZeroPerpendicularOrNotFinite) {
    const Surface cube = made(cube_surface()).surface;
    const SurfacePoint start{2, {0.2, 0.3, 0.5}};
    const double infinity = std::numeric_limits<double>::infinity();
    for (const Point3 move : {Point3{}, Point3{infinity, 0, 0}, Point3{0, std::nan(""), 0}, cube.normal(2)}) {
        const SurfacePoint end = cube.trace(start, move);
        EXPECT_EQ(end.face, start.face);
        EXPECT_EQ(end.weights, start.weights);
    }
    expect_inside(cube.trace(start, {1e308, -1e308, 1e300}), cube);
}

/// On a plane, a straight line is a sum, whichever vertices and edges it passes.
TEST(Surface, TracesThroughVerticesAndAlongEdges) {
    const Surface square = made(square_surface(8)).surface;
    for (std::uint32_t f = 0; f < square.face_count(); ++f) {
        for (const std::array<double, 3> weights :
             {std::array<double, 3>{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.25, 0.5, 0.25}}) {
            const Point3 p = square.position({f, weights});
            for (int x = 0; x <= 8; ++x) {
                for (int y = 0; y <= 8; ++y) {
                    const Point3 move{x / 8. - p.x, y / 8. - p.y, 0};
                    const SurfacePoint end = square.trace({f, weights}, move);
                    expect_inside(end, square);
                    expect_near(square.position(end), p + move, 1e-8);
                }
            }
        }
    }
}

TEST(Surface, TracesGreatCircles) {
    const Surface sphere = made(test::sphere_surface(5)).surface;
    Random random(3, 4);
    for (int i = 0; i < 200; ++i) {
        const auto face = static_cast<std::uint32_t>(random.uniform() * static_cast<double>(sphere.face_count()));
        const SurfacePoint start{face, {0.2, 0.5, 0.3}};
        const Point3 p = sphere.to_input(sphere.position(start));
        const Point3 sideways = cross(p, {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5});
        const double angle = 3 * random.uniform();
        const Point3 direction = 1 / length(sideways) * sideways;
        const SurfacePoint end = sphere.trace(start, angle / sphere.scale() * direction);
        expect_near(sphere.to_input(sphere.position(end)), std::cos(angle) * p + std::sin(angle) * direction, 0.02);
    }
}

/// Follows a line from the middle of the bottom of the unit cube.
TEST(Surface, TracesLinesAroundACube) {
    const Surface surface = made(cube_surface()).surface;
    SurfacePoint start;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto positions = surface.positions(f);
        if (positions[0].z + positions[1].z + positions[2].z == 0) start = {f, {0.5, 0.25, 0.25}};
    }
    const Point3 p = surface.position(start);
    const SurfacePoint side = surface.trace(start, {1, 0, 0});
    expect_inside(side, surface);
    expect_near(surface.position(side), {1, p.y, p.x}, 1e-9);
    expect_near(surface.position(surface.trace(start, {2, 0, 0})), {1 - p.x, p.y, 1}, 1e-9);
    expect_near(surface.position(surface.trace(start, {4, 0, 0})), p, 1e-9);
    expect_near(surface.position(surface.trace(start, {0, 400, 0})), p, 1e-7);
}

TEST(Surface, FindsNearestPoints) {
    const Surface cube = made(cube_surface()).surface;
    const auto nearest = [](const Surface& surface, Point3 p) {
        const SurfacePoint found = surface.nearest(p);
        expect_inside(found, surface);
        return surface.position(found);
    };
    expect_near(nearest(cube, {0.25, 0.5, 0.9}), {0.25, 0.5, 1}, 1e-12);
    expect_near(nearest(cube, {0.25, 2, 3}), {0.25, 1, 1}, 1e-12);
    expect_near(nearest(cube, {1e308, -1e308, 1e308}), {1, 0, 1}, 1e-12);
    EXPECT_EQ(nearest(cube, {std::numeric_limits<double>::infinity(), 1e6, 0.5}).x, 1);

    Surface sphere = made(test::sphere_surface(4)).surface;
    sphere.nearest({});
    const Surface moved = std::move(sphere);
    Random random(1, 2);
    for (int i = 0; i < 1000; ++i) {
        const Point3 p{random.uniform() * 4 - 2, random.uniform() * 4 - 2, random.uniform() * 4 - 2};
        const Point3 found = moved.to_input(nearest(moved, moved.from_input(p)));
        EXPECT_NEAR(length(found - p), std::abs(length(p) - 1), 0.002);
        EXPECT_NEAR(length(found), 1, 0.002);
    }
}

TEST(Surface, FindsNearestPointsAmongNeedlesAndWithinADistance) {
    const Surface surface = made(test::needle_prism(100)).surface;
    Random random(3, 1);
    for (int i = 0; i < 200; ++i) {
        const Point3 p{random.uniform() * 2 - 0.5, random.uniform() * 2 - 0.5, random.uniform() * 2 - 0.5};
        const double distance = length(surface.position(surface.nearest(p)) - p);
        for (std::uint32_t face = 0; face < surface.face_count(); ++face) {
            for (std::size_t k = 0; k < 3; ++k) {
                for (const double t : {0.0, 0.25, 0.5}) {
                    SurfacePoint other{face, {}};
                    other.weights[k] = 1 - t;
                    other.weights[(k + 1) % 3] = t;
                    ASSERT_GE(length(surface.position(other) - p), distance - 1e-12);
                }
            }
        }
        EXPECT_FALSE(surface.nearest_within(p, distance * (1 - 1e-9)));
        const auto near = surface.nearest_within(p, distance * (1 + 1e-9));
        ASSERT_TRUE(near);
        EXPECT_EQ(length(surface.position(*near) - p), distance);
    }
}

/// Returns triangles between vertices on a small grid, so that many coincide, overlap, or have no area.
TriangleSoup random_soup(Random& random) {
    const auto below = [&random](double n) { return static_cast<std::uint32_t>(random.uniform() * n); };
    TriangleSoup soup;
    const double side = 2 + below(3), depth = 1 + below(3);
    const std::uint32_t vertices = 3 + below(20), triangles = 1 + below(40);
    for (std::uint32_t v = 0; v < vertices; ++v) {
        soup.vertices.push_back({0. + below(side), 0. + below(side), 0. + below(depth)});
        if (below(8) == 0) soup.vertices.back().x += 1e-12 * random.uniform();
    }
    for (std::uint32_t t = 0; t < triangles; ++t) {
        soup.triangles.push_back({below(vertices), below(vertices), below(vertices)});
    }
    return soup;
}

TEST(Surface, MakesSurfacesOfAnyTriangles) {
    Random random(5, 6);
    int usable = 0;
    for (int i = 0; i < 2000 && !HasFailure(); ++i) {
        SCOPED_TRACE("soup " + std::to_string(i));
        const TriangleSoup soup = random_soup(random);
        const auto result = Surface::create(soup, i % 3 == 0 ? std::optional(0.5) : std::nullopt);
        if (!result) {
            EXPECT_EQ(result.error().code, ErrorCode::Unusable);
            continue;
        }
        ++usable;
        const Surface& surface = result->surface;
        expect_valid(surface);
        for (int j = 0; j < 20; ++j) {
            const double a = random.uniform(), b = (1 - a) * random.uniform();
            const SurfacePoint start{
                static_cast<std::uint32_t>(j % static_cast<int>(surface.face_count())),
                j % 4 == 0 ? std::array<double, 3>{0, 1, 0} : std::array{a, b, std::max(0.0, 1 - a - b)}};
            const Point3 move{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
            const SurfacePoint end = surface.trace(start, (j % 5 == 0 ? 1e6 : 1) * move);
            expect_inside(end, surface);
            EXPECT_EQ(surface.component(end.face), surface.component(start.face));
            const SurfacePoint nearest = surface.nearest(surface.position(end));
            expect_inside(nearest, surface);
            expect_near(surface.position(nearest), surface.position(end), 1e-9);
        }
    }
    EXPECT_GT(usable, 1000);
}

/// Returns a strip that turns down by 100 degrees: at an edge, or at two edges with a chamfer of the given width
/// between them.
TriangleSoup bent_strip(double chamfer) {
    const auto direction = [](double degrees) {
        return Point3{std::cos(degrees * kPi / 180), 0, -std::sin(degrees * kPi / 180)};
    };
    std::vector<Point3> profile{{-1, 0, 0}, {0, 0, 0}};
    if (chamfer > 0) profile.push_back(profile.back() + chamfer * direction(50));
    profile.push_back(profile.back() + direction(100));
    TriangleSoup soup;
    for (const Point3& p : profile)
        soup.vertices.insert(soup.vertices.end(), {p - Point3{0, 1, 0}, p + Point3{0, 1, 0}});
    for (std::uint32_t v = 0; v + 2 < soup.vertices.size(); v += 2)
        soup.triangles.insert(soup.triangles.end(), {{v, v + 2, v + 1}, {v + 1, v + 2, v + 3}});
    return soup;
}

TEST(Unfolded, TellsSharpEdgesFromBends) {
    for (const double chamfer : {0.0, 0.02}) {
        SCOPED_TRACE(chamfer);
        const TriangleSoup soup = bent_strip(chamfer);
        const Surface surface = made(soup).surface;
        const SurfacePoint from = surface.nearest(surface.from_input({-0.5, 0.1, 0}));
        const Point3 end = 0.25 * (soup.vertices.end()[-1] + soup.vertices.end()[-2] + soup.vertices.end()[-3] +
                                   soup.vertices.end()[-4]);
        const SurfacePoint to = surface.nearest(surface.from_input(end));
        ASSERT_TRUE(is_sharp(surface.normal(from.face), surface.normal(to.face)));
        const auto flat = unfolded(surface, from, surface.position(to) - surface.position(from), to.face, 10);
        ASSERT_TRUE(flat);
        EXPECT_EQ(flat->crosses_sharp_edge, chamfer == 0);
        EXPECT_NEAR(surface.scale() * length(flat->vector), std::hypot(1, 0.1), 2 * chamfer + 1e-9);
    }
}

}  // namespace
}  // namespace ccdt
