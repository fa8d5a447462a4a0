// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/volume_transport.h"

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

TEST(VolumeTransport, UndoesALongWave) {
    const std::vector<Point3> lattice = wavy_lattice(0);
    for (const bool periodic : {true, false}) {
        const BoxDomain3 domain{{1, 1, 1}, periodic};
        const VolumeSpacing spacing(domain, VoxelDensity::uniform(), lattice.size(), inline_executor());
        VolumeTransport transport(domain, VoxelDensity::uniform(), spacing, lattice.size(), false, inline_executor());
        std::vector<Point3> points = wavy_lattice(0.01);
        const double before = transport.even_out(points, points.size(), {});
        EXPECT_GT(before, 1);
        for (int i = 0; i < 4; ++i) transport.even_out(points, points.size(), {});
        EXPECT_LT(transport.even_out(points, points.size(), {}), 1e-6 * before) << periodic;
        EXPECT_LT(largest_distance(points, lattice), 2e-4) << periodic;
    }
}

TEST(VolumeTransport, MovesFreeSitesOnly) {
    const BoxDomain3 torus{{1, 1, 1}, true};
    const std::vector<Point3> before = wavy_lattice(0.01);
    const VolumeSpacing spacing(torus, VoxelDensity::uniform(), before.size(), inline_executor());
    VolumeTransport transport(torus, VoxelDensity::uniform(), spacing, before.size(), false, inline_executor());
    std::vector<Point3> points = before;
    transport.even_out(points, 100, {});
    EXPECT_GT(largest_distance(std::span(points).first(100), std::span(before).first(100)), 1e-3);
    EXPECT_EQ(largest_distance(std::span(points).subspan(100), std::span(before).subspan(100)), 0);
}

}  // namespace
}  // namespace ccdt
