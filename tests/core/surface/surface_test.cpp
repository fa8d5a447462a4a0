// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/surface/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <stop_token>

#include "core/random.h"
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
        const auto [a, b, c] = surface.places(f);
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
    ASSERT_LT(point.face, surface.face_count());
    double sum = 0;
    for (const double weight : point.weights) {
        EXPECT_GE(weight, 0);
        sum += weight;
    }
    EXPECT_NEAR(sum, 1, 1e-12);
}

void expect_near(Point3 a, Point3 b, double tolerance) {
    EXPECT_LT(length(a - b), tolerance) << '(' << a.x << ' ' << a.y << ' ' << a.z << ") is not (" << b.x << ' ' << b.y
                                        << ' ' << b.z << ')';
}

/// Checks that every surface fulfils the contract of the class.
void expect_valid(const Surface& surface) {
    ASSERT_GT(surface.face_count(), 0U);
    std::vector<std::size_t> corners_at(surface.vertex_count());
    double total = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto corners = surface.corners(f);
        EXPECT_NEAR(length(surface.normal(f)), 1, 1e-9);
        EXPECT_LT(surface.component(f), surface.component_count());
        total += surface.area(f);
        for (std::uint32_t k = 0; k < 3; ++k) {
            ASSERT_LT(corners[k], surface.vertex_count());
            EXPECT_NE(corners[k], corners[(k + 1) % 3]);
            ++corners_at[corners[k]];
            const std::uint32_t edge = 4 * f + k, twin = surface.twin(edge);
            if (twin == Surface::kNone) {
                EXPECT_TRUE(surface.is_crease(edge));
                continue;
            }
            EXPECT_EQ(surface.twin(twin), edge);
            EXPECT_EQ(surface.is_crease(twin), surface.is_crease(edge));
            EXPECT_EQ(surface.corners(twin / 4)[twin % 4], corners[(k + 1) % 3]);
            EXPECT_EQ(surface.corners(twin / 4)[(twin % 4 + 1) % 3], corners[k]);
            if (!surface.is_crease(edge)) {
                EXPECT_EQ(surface.component(twin / 4), surface.component(f));
            }
        }
    }
    EXPECT_NEAR(surface.total_area(), total, 1e-9 * total);
    // Each vertex has one fan: rotating around it from any corner reaches all its corners.
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            std::size_t seen = 0;
            std::uint32_t at = 4 * f + k;
            do {
                ++seen;
                at = surface.twin(at / 4 * 4 + (at % 4 + 2) % 3);
            } while (at != Surface::kNone && at != 4 * f + k);
            const std::uint32_t vertex = surface.corners(f)[k];
            for (at = surface.twin(4 * f + k); at != Surface::kNone && seen < corners_at[vertex]; ++seen) {
                at = surface.twin(at / 4 * 4 + (at % 4 + 1) % 3);
            }
            EXPECT_EQ(seen, corners_at[vertex]);
        }
    }
    for (std::uint32_t v = 0; v < surface.vertex_count(); ++v) {
        EXPECT_NEAR(length(surface.vertex_normal(v)), 1, 1e-9);
        const Point3 p = surface.vertex(v);
        EXPECT_GE(std::min({p.x, p.y, p.z}), 0);
        EXPECT_LE(std::max({p.x, p.y, p.z}), 1);
    }
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

/// Follows a line from the middle of the bottom of the unit cube.
TEST(Surface, TracesLinesAroundACube) {
    const Surface surface = made(cube_surface()).surface;
    SurfacePoint start;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto places = surface.places(f);
        if (places[0].z + places[1].z + places[2].z == 0) start = {f, {0.5, 0.25, 0.25}};
    }
    const Point3 p = surface.place(start);
    const SurfacePoint side = surface.trace(start, {1, 0, 0});
    expect_inside(side, surface);
    expect_near(surface.place(side), {1, p.y, p.x}, 1e-9);
    expect_near(surface.place(surface.trace(start, {2, 0, 0})), {1 - p.x, p.y, 1}, 1e-9);
    expect_near(surface.place(surface.trace(start, {4, 0, 0})), p, 1e-9);
    expect_near(surface.place(surface.trace(start, {0, 400, 0})), p, 1e-7);
}

TEST(Surface, FindsNearestPoints) {
    const Surface cube = made(cube_surface()).surface;
    const auto nearest = [](const Surface& surface, Point3 p) {
        const SurfacePoint found = surface.nearest(p);
        expect_inside(found, surface);
        return surface.place(found);
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

}  // namespace
}  // namespace ccdt
