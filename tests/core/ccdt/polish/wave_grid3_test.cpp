// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/wave_grid.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/base/thread_executor.h"

namespace ccdt {
namespace {

constexpr Point3 kSides{1, 0.8, 0.5};
constexpr double kTau = 2 * std::numbers::pi;

std::vector<Point3> points(std::size_t count) {
    Random random(3, 0);
    std::vector<Point3> points(count);
    for (Point3& p : points)
        p = {kSides.x * random.uniform(), kSides.y * random.uniform(), kSides.z * random.uniform()};
    return points;
}

TEST(WaveGrid3, TransformsPointsToWaves) {
    const std::vector<Point3> sites = points(50);
    for (const bool periodic : {true, false}) {
        WaveGrid3 grid(periodic, kSides, {24, 20, 12});
        grid.clear();
        grid.spread(sites, {});
        grid.transform();
        std::size_t waves = 0;
        grid.with_coefficients([&](auto coefficients) {
            grid.for_waves([&](std::size_t number, const WaveGrid3::Wave& wave) {
                const Point3 f = grid.frequency(wave), cell = grid.cell();
                if (std::max({std::abs(f.x) * cell.x, std::abs(f.y) * cell.y, std::abs(f.z) * cell.z}) > 0.26) return;
                ++waves;
                std::complex<double> sum = 0;
                for (const Point3 p : sites) {
                    sum += periodic
                               ? std::polar(1.0, -kTau * dot(f, p))
                               : std::cos(kTau * f.x * p.x) * std::cos(kTau * f.y * p.y) * std::cos(kTau * f.z * p.z);
                }
                const std::complex<double> value = coefficients[number] / (grid.window(wave) * grid.copies());
                EXPECT_LT(std::abs(value - sum), 1e-3) << periodic << ' ' << f.x << ' ' << f.y << ' ' << f.z;
            });
        });
        EXPECT_GT(waves, 400u);
    }
}

TEST(WaveGrid3, ReturnsGradientsOfWaves) {
    const std::vector<Point3> sites = points(50);
    const Point3 f{2, 1 / 0.8, -1 / 0.5};  // a wave of the torus; a box has it with the same sign of all axes
    for (const bool periodic : {true, false}) {
        WaveGrid3 grid(periodic, kSides, {24, 20, 12});
        const WaveGrid3::Wave wave = periodic ? WaveGrid3::Wave{2, 1, -1} : WaveGrid3::Wave{4, 2, 2};
        grid.with_coefficients([&](auto coefficients) { coefficients[grid.number(wave)] = 1 / grid.window(wave); });
        grid.transform_back();
        for (const Point3 p : sites) {
            Point3 gradient = p;
            grid.gradients(std::span(&p, 1), std::span(&gradient, 1));
            if (periodic) {
                const double slope = -2 * kTau * std::sin(kTau * dot(f, p));
                EXPECT_LT(length(gradient - slope * f), 5e-3);
            } else {
                // The inverse cosine transform doubles every axis.
                const double expected = -8 * kTau * f.x * std::sin(kTau * f.x * p.x) * std::cos(kTau * f.y * p.y) *
                                        std::cos(kTau * f.z * p.z);
                EXPECT_NEAR(gradient.x, expected, 5e-3);
            }
        }
    }
}

TEST(WaveGrid3, WeighsPoints) {
    const std::vector<Point3> sites = points(2);
    WaveGrid3 grid(true, kSides, {8, 8, 8});
    grid.clear();
    grid.spread(sites, std::vector<double>{2, 0.5});
    grid.transform();
    grid.with_coefficients(
        [&](auto coefficients) { EXPECT_NEAR(std::abs(coefficients[0]) / grid.window({}), 2.5, 1e-5); });
}

TEST(WaveGrid3, GivesTheSameBitsForAnyNumberOfThreads) {
    const std::vector<Point3> sites = points(5000);
    ThreadExecutor threads(3);
    // An even and an odd number of bands of layers.
    for (const int layers : {24, 32}) {
        for (const bool periodic : {true, false}) {
            WaveGrid3 one(periodic, kSides, {40, 40, layers});
            WaveGrid3 three(periodic, kSides, {40, 40, layers}, threads);
            for (WaveGrid3* grid : {&one, &three}) {
                grid->clear();
                grid->spread(sites, {});
                grid->transform();
                grid->backward();
            }
            EXPECT_TRUE(std::ranges::equal(one.grid(), three.grid()));
        }
    }
}

}  // namespace
}  // namespace ccdt
