// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/analysis/laplacian_modes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <stop_token>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/surface/surface.h"
#include "tests/support/surfaces.h"

namespace ccdt {
namespace {

constexpr double kPi = std::numbers::pi;

/// A surface's vertices without duplicates, in the coordinates of the soup, and its triangles.
struct Mesh {
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<double> areas;  ///< [vertices] a third of the area of the triangles around each vertex

    explicit Mesh(const TriangleSoup& soup) {
        const Surface surface = Surface::create(soup, std::nullopt).value().surface;
        for (std::uint32_t v = 0; v < surface.vertex_count(); ++v)
            vertices.push_back(surface.to_input(surface.vertex(v)));
        areas.resize(vertices.size());
        for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
            triangles.push_back(surface.corners(f));
            const double area = surface.area(f) * surface.scale() * surface.scale();
            for (const std::uint32_t v : surface.corners(f)) areas[v] += area / 3;
        }
    }
};

LaplacianModes modes_of(const TriangleSoup& soup, std::size_t count) {
    const Mesh mesh(soup);
    return find_laplacian_modes(mesh.vertices, mesh.triangles, count).value();
}

TEST(LaplacianModes, HasTheEigenvaluesOfTheSphere) {
    const auto modes = modes_of(test::sphere_surface(4), 24);
    std::vector<double> expected;
    for (int l = 1; l <= 4; ++l) expected.insert(expected.end(), static_cast<std::size_t>(2 * l + 1), l * (l + 1.0));
    ASSERT_EQ(modes.eigenvalues.size(), expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k)
        EXPECT_NEAR(modes.eigenvalues[k], expected[k], 0.01 * expected[k]);
}

TEST(LaplacianModes, HasFreeBorders) {
    const auto modes = modes_of(test::square_surface(32), 12);
    std::vector<double> expected;
    for (int i = 0; i < 8; ++i) {
        for (int j = 0; j < 8; ++j) expected.push_back(kPi * kPi * (i * i + j * j));
    }
    std::ranges::sort(expected);
    for (std::size_t k = 0; k < 12; ++k) EXPECT_NEAR(modes.eigenvalues[k], expected[k + 1], 0.02 * expected[k + 1]);
}

TEST(LaplacianModes, IsOrthogonalToTheConstantAndToEachOther) {
    const Mesh torus(test::torus_surface(2, 1, 64, 32));
    const std::size_t count = 9, vertices = torus.vertices.size();
    const auto modes = find_laplacian_modes(torus.vertices, torus.triangles, count).value();
    const auto mean = [&](auto&& value) {
        double sum = 0, area = 0;
        for (std::size_t v = 0; v < vertices; ++v) {
            sum += torus.areas[v] * value(v);
            area += torus.areas[v];
        }
        return sum / area;
    };
    const auto mode = [&](std::size_t k, std::size_t v) { return modes.values[k * vertices + v]; };
    for (std::size_t k = 0; k < count; ++k) {
        EXPECT_NEAR(mean([&](std::size_t v) { return mode(k, v); }), 0, 1e-9) << k;
        for (std::size_t l = 0; l <= k; ++l) {
            const double product = mean([&](std::size_t v) { return mode(k, v) * mode(l, v); });
            EXPECT_NEAR(product, k == l ? 1 : 0, 0.02) << k << ' ' << l;
        }
    }
}

TEST(LaplacianModes, FindsAllModesOfEqualComponents) {
    TriangleSoup spheres;
    for (int i = 0; i < 5; ++i) {
        TriangleSoup sphere = test::sphere_surface(2);
        for (Point3& p : sphere.vertices) p.x += 3 * i;
        spheres = i == 0 ? sphere : test::joined(spheres, sphere);
    }
    const auto modes = modes_of(spheres, 4 + 15 + 25);
    for (std::size_t k = 0; k < modes.eigenvalues.size(); ++k) {
        const double expected = k < 4 ? 0 : k < 19 ? 2 : 6;
        EXPECT_NEAR(modes.eigenvalues[k], expected, 0.06 * expected + 1e-9) << k;
    }
}

TEST(LaplacianModes, AcceptsNeedles) {
    const TriangleSoup strip = test::grid_surface(200, 2, [](double u, double v) { return Point3{u, 1e-6 * v, 0}; });
    const auto modes = modes_of(strip, 5);
    for (std::size_t k = 0; k < 5; ++k) {
        const double expected = std::pow(kPi * static_cast<double>(k + 1), 2);
        EXPECT_NEAR(modes.eigenvalues[k], expected, 0.01 * expected);
    }
}

TEST(LaplacianModes, GivesTheSameBytesAgain) {
    const TriangleSoup sphere = test::sphere_surface(3);
    EXPECT_EQ(modes_of(sphere, 20).values, modes_of(sphere, 20).values);
}

TEST(LaplacianModes, Stops) {
    const Mesh sphere(test::sphere_surface(3));
    std::stop_source source;
    source.request_stop();
    const auto modes = find_laplacian_modes(sphere.vertices, sphere.triangles, 20, source.get_token());
    ASSERT_FALSE(modes);
    EXPECT_EQ(modes.error().code, ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt
