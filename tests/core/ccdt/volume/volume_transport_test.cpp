// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/volume_transport.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

/// Returns a lattice of 12 x 12 x 12 points, moved by a wave with one period along x.
std::vector<Point3> wavy_lattice(double amplitude) {
    std::vector<Point3> points;
    for (int k = 0; k < 12; ++k) {
        for (int j = 0; j < 12; ++j) {
            for (int i = 0; i < 12; ++i) {
                const Point3 p{(i + 0.5) / 12, (j + 0.5) / 12, (k + 0.5) / 12};
                points.push_back(p + Point3{amplitude * std::sin(2 * std::numbers::pi * p.x), 0, 0});
            }
        }
    }
    return points;
}

double largest_distance(std::span<const Point3> a, std::span<const Point3> b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, length(a[i] - b[i]));
    return largest;
}

/// Applies one round to sites, and returns the largest power before.
double even_out(OctaveTransport<Point3>& transport, const BoxDomain3& domain, std::vector<Point3>& sites) {
    const double spacing = std::cbrt(domain.volume() / static_cast<double>(sites.size()));
    std::vector<Point3> moves(sites.size());
    EXPECT_TRUE(transport.measure(sites, {}, {}));
    const double power = transport.largest_power(static_cast<double>(sites.size()));
    EXPECT_TRUE(transport.find_moves(sites, moves, [&](Point3) { return spacing; }, {}));
    for (std::size_t i = 0; i < sites.size(); ++i) sites[i] = domain.inside(sites[i] + moves[i]);
    return power;
}

TEST(VolumeTransport, UndoesALongWave) {
    const std::vector<Point3> lattice = wavy_lattice(0);
    for (const bool periodic : {true, false}) {
        const BoxDomain3 domain{{1, 1, 1}, periodic};
        const VolumeSpacing spacing(domain, VoxelDensity::uniform(), lattice.size(), inline_executor());
        auto transport =
            volume_transport(domain, 1, VoxelDensity::uniform(), spacing, lattice.size(), false, inline_executor());
        std::vector<Point3> points = wavy_lattice(0.01);
        const double before = even_out(transport, domain, points);
        EXPECT_GT(before, 1);
        for (int i = 0; i < 4; ++i) even_out(transport, domain, points);
        EXPECT_LT(even_out(transport, domain, points), 1e-6 * before) << periodic;
        EXPECT_LT(largest_distance(points, lattice), 2e-4) << periodic;
    }
}

/// The octaves share one grid, so that an even pattern of varying density must not move.
TEST(VolumeTransport, FollowsAVaryingDensity) {
    constexpr BoxDomain3 kTorus{{1, 1, 1}, true};
    // Density 1 + cos(2 pi x) / 2 in 64 slabs. Points at equal quantiles along x have this density.
    std::vector<double> values;
    for (int i = 0; i < 64; ++i) values.push_back(1 + std::cos(2 * std::numbers::pi * (i + 0.5) / 64) / 2);
    const VoxelDensity density = VoxelDensity::create({64, 1, 1}, values).value();
    std::vector<Point3> wanted = wavy_lattice(0), points;
    for (Point3& p : wanted) p.x = density.cut({{0, 0, 0}, {1, 1, 1}}, 0, p.x);
    const VolumeSpacing spacing(kTorus, density, wanted.size(), inline_executor());
    auto transport = volume_transport(kTorus, 1, density, spacing, wanted.size(), false, inline_executor());
    for (const Point3 p : wanted) points.push_back(p + Point3{0.01 * std::sin(2 * std::numbers::pi * p.x), 0, 0});
    for (int i = 0; i < 5; ++i) even_out(transport, kTorus, points);
    EXPECT_LT(largest_distance(points, wanted), 2e-3);
}

}  // namespace
}  // namespace ccdt
