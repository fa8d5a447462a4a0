// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/polygon_moments.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::grid_of;

const Domain& rectangle() {
    static const Domain domain = Domain::rectangle(2, 1).value();  // 1 x 0.5 in the unit frame
    return domain;
}

void expect_moments(const Moments& found, double mass, Point first, double tolerance) {
    EXPECT_NEAR(found.mass, mass, tolerance);
    EXPECT_NEAR(found.first.x, first.x, tolerance);
    EXPECT_NEAR(found.first.y, first.y, tolerance);
}

TEST(SquaredDensity, IsOneIfUniform) {
    const SquaredDensity weight(rectangle(), Density::uniform());
    const std::vector<Point> triangle{{0.1, 0.1}, {0.4, 0.1}, {0.1, 0.4}};
    // Area 0.045 around the centroid (0.2, 0.2).
    expect_moments(weight.over(triangle, {0.2, 0.2}), 0.045, {0, 0}, 1e-15);
    expect_moments(weight.over(triangle, {0, 0.1}), 0.045, {0.045 * 0.2, 0.045 * 0.1}, 1e-15);
}

TEST(SquaredDensity, SquaresEachCell) {
    // Cells of 0.25 x 0.25. A strip of 0.1 of the rectangle lies in the first column, and one of 0.2 in the second.
    const Density density = grid_of(4, 2, [](int i, int j) { return i + 1.0 + 4 * j; });
    const SquaredDensity weight(rectangle(), density);
    const std::vector<Point> box{{0.15, 0}, {0.45, 0}, {0.45, 0.25}, {0.15, 0.25}};
    const Moments found = weight.over(box, {0, 0});
    const double unit = 1.0 / 64 * 16;  // relative to the squared largest value, in cells
    const double first = unit * 1 * 0.1 * 0.25, second = unit * 4 * 0.2 * 0.25;
    const double scale = found.mass / (first + second);
    expect_moments({found.mass / scale, 1 / scale * found.first}, first + second,
                   {first * 0.2 + second * 0.35, (first + second) * 0.125}, 1e-14);
}

/// Computes the moments by a sum over the points of a fine grid.
Moments sum_over(const std::vector<Point>& corners, const Density& density, Point from) {
    constexpr int kPositions = 1500;
    Moments sum;
    for (int j = 0; j < kPositions; ++j) {
        for (int i = 0; i < kPositions; ++i) {
            const Point p{(i + 0.5) / kPositions, (j + 0.5) / kPositions / 2};
            bool inside = true;
            for (std::size_t k = 0; k < corners.size(); ++k) {
                const Point a = corners[k], b = corners[(k + 1) % corners.size()];
                inside = inside && cross(b - a, p - a) > 0;
            }
            if (!inside) continue;
            const double value =
                density.value(static_cast<int>(p.x * density.width()), static_cast<int>(p.y * 2 * density.height()));
            sum.mass += value * value;
            sum.first = sum.first + value * value * (p - from);
        }
    }
    return sum;
}

TEST(SquaredDensity, AgreesWithANumericalSum) {
    Random random(5, 0);
    const Density density = grid_of(17, 11, [&](int, int) { return random.uniform(); });
    const SquaredDensity weight(rectangle(), density);
    const std::vector<Point> polygon{{0.05, 0.2}, {0.3, 0.02}, {0.93, 0.11}, {0.8, 0.4}, {0.21, 0.47}};
    const Point from{0.4, 0.3};
    const Moments found = weight.over(polygon, from), expected = sum_over(polygon, density, from);
    const double scale = expected.mass / found.mass;
    EXPECT_NEAR(scale * found.first.x / expected.mass, expected.first.x / expected.mass, 1e-4);
    EXPECT_NEAR(scale * found.first.y / expected.mass, expected.first.y / expected.mass, 1e-4);
    // Masses have an arbitrary unit, so their ratio is compared with the ratio of the sums.
    const std::vector<Point> other{{0.5, 0.1}, {0.9, 0.3}, {0.6, 0.45}};
    EXPECT_NEAR(weight.over(other, from).mass / found.mass, sum_over(other, density, from).mass / expected.mass, 1e-3);
}

TEST(SquaredDensity, AveragesAVeryFineGrid) {
    const Density fine = grid_of(3000, 2000, [](int i, int j) { return 1.0 + i / 1500 + 2 * (j / 1000); });
    const Density coarse = grid_of(2, 2, [](int i, int j) { return 1.0 + i + 2 * j; });
    const std::vector<Point> polygon{{0.1, 0.1}, {0.9, 0.2}, {0.5, 0.45}};
    const Moments a = SquaredDensity(rectangle(), fine).over(polygon, {0.5, 0.25});
    const Moments b = SquaredDensity(rectangle(), coarse).over(polygon, {0.5, 0.25});
    EXPECT_NEAR(a.first.x / a.mass, b.first.x / b.mass, 1e-4);
    EXPECT_NEAR(a.first.y / a.mass, b.first.y / b.mass, 1e-4);
}

}  // namespace
}  // namespace ccdt
