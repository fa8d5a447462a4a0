// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/analysis/surface_analysis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/surfaces.h"

namespace ccdt {
namespace {

Surface surface_of(const TriangleSoup& soup) {
    return Surface::create(soup, std::nullopt).value().surface;
}

std::vector<SurfacePoint> random_points(const Surface& surface, std::size_t count, std::uint64_t seed) {
    std::vector<double> sums;
    double sum = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) sums.push_back(sum += surface.area(f));
    Random random(seed, 0);
    std::vector<SurfacePoint> points;
    while (points.size() < count) {
        const auto face = std::ranges::lower_bound(sums, random.uniform() * sum) - sums.begin();
        const double a = std::sqrt(random.uniform()), b = random.uniform();
        points.push_back({static_cast<std::uint32_t>(face), {1 - a, a * (1 - b), a * b}});
    }
    return points;
}

double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

TEST(SurfaceAnalysis, FindsPowerOneForRandomPoints) {
    for (const Surface& surface : {surface_of(test::torus_surface(2, 0.5, 40, 16)), surface_of(test::cube_surface())}) {
        double power = 0, squares = 0;
        constexpr int kSeeds = 10;
        for (int seed = 0; seed < kSeeds; ++seed) {
            const auto found =
                analyse_surface(surface, random_points(surface, 1000, static_cast<std::uint64_t>(seed)), 20);
            power += mean(found->power) / kSeeds;
            for (const double p : found->power) squares += p * p / (20.0 * kSeeds);
        }
        // The square of a normal variable has mean 1, and a mean square of 3.
        EXPECT_NEAR(power, 1, 0.3);
        EXPECT_NEAR(squares, 3, 1.5);
    }
}

TEST(SurfaceAnalysis, MeasuresALatticeOnASquare) {
    const Surface square = surface_of(test::square_surface(2));
    std::vector<SurfacePoint> points;
    constexpr int kRows = 30;
    for (int i = 0; i < kRows; ++i) {
        for (int j = 0; j < kRows; ++j) points.push_back(square.nearest({(i + 0.5) / kRows, (j + 0.5) / kRows, 0}));
    }
    const auto found = analyse_surface(square, points, 30);
    ASSERT_TRUE(found);
    const double hexagonal = std::sqrt(2 / std::sqrt(3.0));
    EXPECT_NEAR(found->min_distance, 1 / hexagonal, 1e-6);
    EXPECT_NEAR(found->mean_distance, 1 / hexagonal, 1e-6);
    // The sum of a cosine over the middles of equal intervals is 0.
    EXPECT_LT(*found->low_frequency_power, 0.01);
    EXPECT_NEAR(found->eigenvalues[0], std::pow(std::numbers::pi, 2), 0.1);
    EXPECT_NEAR(found->frequency[0], 0.5 / kRows, 1e-3);
}

TEST(SurfaceAnalysis, IgnoresTheOtherSideOfAThinPlate) {
    TriangleSoup plate = test::cube_surface();
    for (Point3& p : plate.vertices) p.z *= 1e-4;
    const Surface surface = surface_of(plate);
    std::vector<SurfacePoint> points;
    for (int i = 0; i < 10; ++i) {
        for (int j = 0; j < 10; ++j) {
            for (const double z : {0.0, 1e-4})
                points.push_back(surface.nearest(surface.from_input({(i + 0.5) / 10, (j + 0.5) / 10, z})));
        }
    }
    EXPECT_NEAR(analyse_surface(surface, points, 10)->min_distance, 1 / std::sqrt(2 / std::sqrt(3.0)), 1e-3);
}

TEST(SurfaceAnalysis, DoesNotDependOnTheTriangles) {
    // The same cube, with 12 and with 192 triangles.
    TriangleSoup fine;
    for (const auto& [a, b, c] : test::cube_surface().triangles) {
        const auto vertices = test::cube_surface().vertices;
        const Point3 u = vertices[b] - vertices[a], v = vertices[c] - vertices[a];
        const auto first = static_cast<std::uint32_t>(fine.vertices.size());
        for (int i = 0; i <= 4; ++i) {
            for (int j = 0; j <= 4; ++j) fine.vertices.push_back(vertices[a] + i / 4.0 * u + j / 4.0 * v);
        }
        for (std::uint32_t i = 0; i < 4; ++i) {
            for (std::uint32_t j = 0; i + j < 4; ++j) {
                const std::uint32_t corner = first + 5 * i + j;
                fine.triangles.push_back({corner, corner + 5, corner + 1});
                if (i + j < 3) fine.triangles.push_back({corner + 5, corner + 6, corner + 1});
            }
        }
    }
    const Surface one = surface_of(test::cube_surface()), other = surface_of(fine);
    const auto points = random_points(one, 300, 1);
    std::vector<SurfacePoint> same;
    for (const SurfacePoint& p : points) same.push_back(other.nearest(one.position(p)));
    const auto a = analyse_surface(one, points, 30), b = analyse_surface(other, same, 30);
    EXPECT_EQ(count_mode_vertices(one, 30), 1538);
    EXPECT_EQ(count_mode_vertices(other, 30), 1538);
    for (std::size_t k = 0; k < 30; ++k) EXPECT_NEAR(a->eigenvalues[k], b->eigenvalues[k], 1e-5 * a->eigenvalues[k]);
    EXPECT_NEAR(*a->low_frequency_power, *b->low_frequency_power, 1e-3);
    EXPECT_NEAR(a->min_distance, b->min_distance, 1e-9);
}

TEST(SurfaceAnalysis, ScalesEigenvaluesWithTheInput) {
    TriangleSoup large = test::torus_surface(2, 0.5, 40, 16);
    const Surface one = surface_of(large);
    for (Point3& p : large.vertices) p = 1000.0 * p;
    const Surface other = surface_of(large);
    const auto points = random_points(one, 100, 1);
    const auto a = analyse_surface(one, points, 10), b = analyse_surface(other, points, 10);
    for (std::size_t k = 0; k < 10; ++k) {
        EXPECT_NEAR(a->eigenvalues[k], 1e6 * b->eigenvalues[k], 1e-5 * a->eigenvalues[k]);
        EXPECT_NEAR(a->frequency[k], b->frequency[k], 1e-6);
    }
    // The first mode of this torus is nearly a wave along its large circle, of length 4 pi.
    EXPECT_NEAR(a->eigenvalues[0], 0.25, 0.03);
}

TEST(SurfaceAnalysis, RejectsTooFewPointsAndModesOutOfRange) {
    const Surface cube = surface_of(test::cube_surface());
    const auto points = random_points(cube, 10, 1);
    const auto error_of = [&](std::size_t count, std::size_t modes) {
        return analyse_surface(cube, std::span(points).first(count), modes).error();
    };
    EXPECT_EQ(error_of(1, 10).code, ErrorCode::Unusable);
    EXPECT_EQ(error_of(1, 10).field, "points");
    EXPECT_EQ(error_of(10, 0).code, ErrorCode::Malformed);
    EXPECT_EQ(error_of(10, 501).field, "modes");
    const Surface large = surface_of(test::square_surface(300));
    const auto error = analyse_surface(large, random_points(large, 10, 1), 400).error();
    EXPECT_EQ(error.code, ErrorCode::LimitExceeded);
    EXPECT_NE(error.message.find("at most 370"), std::string::npos) << error.message;
}

TEST(SurfaceAnalysis, Stops) {
    const Surface cube = surface_of(test::cube_surface());
    std::stop_source source;
    source.request_stop();
    EXPECT_EQ(analyse_surface(cube, random_points(cube, 10, 1), 10, source.get_token()).error().code,
              ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt
