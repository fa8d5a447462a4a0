// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/wave_grid.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/parallel/thread_executor.h"
#include "core/random.h"

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

TEST(WaveGrid, TransformsPointsToWaves) {
    const std::vector<Point3> sites = points(50);
    for (const bool periodic : {true, false}) {
        WaveGrid grid({kSides, periodic}, {24, 20, 12}, inline_executor());
        grid.spread(sites, {});
        grid.forward();
        std::size_t waves = 0;
        grid.for_waves([&](auto coefficients, const WaveGrid::Wave& wave, std::size_t) {
            const Point3 f = wave.frequency, cell{1.0 / 24, 0.8 / 20, 0.5 / 12};
            if (std::max({std::abs(f.x) * cell.x, std::abs(f.y) * cell.y, std::abs(f.z) * cell.z}) > 0.26) return;
            ++waves;
            std::complex<double> sum = 0;
            for (const Point3 p : sites) {
                sum += periodic ? std::polar(1.0, -kTau * dot(f, p))
                                : std::cos(kTau * f.x * p.x) * std::cos(kTau * f.y * p.y) * std::cos(kTau * f.z * p.z);
            }
            const std::complex<double> value = coefficients[wave.number] / (wave.window * grid.copies());
            EXPECT_LT(std::abs(value - sum), 1e-3) << periodic << ' ' << f.x << ' ' << f.y << ' ' << f.z;
        });
        EXPECT_GT(waves, 400u);
    }
}

TEST(WaveGrid, ReturnsGradientsOfWaves) {
    const std::vector<Point3> sites = points(50);
    const Point3 f{2, 1 / 0.8, -1 / 0.5};  // a wave of the torus; a box has it with the same sign of all axes
    for (const bool periodic : {true, false}) {
        WaveGrid grid({kSides, periodic}, {24, 20, 12}, inline_executor());
        grid.spread({}, {});
        grid.forward();
        grid.for_waves([&](auto coefficients, const WaveGrid::Wave& wave, std::size_t) {
            const Point3 wanted = periodic ? f : Point3{f.x, f.y, -f.z};
            if (length(wave.frequency - wanted) < 1e-9) coefficients[wave.number] = 1 / wave.window;
        });
        grid.backward();
        for (const Point3 p : sites) {
            const Point3 gradient = grid.gradient(p);
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

TEST(WaveGrid, WeighsPoints) {
    const std::vector<Point3> sites = points(2);
    WaveGrid grid({kSides, true}, {8, 8, 8}, inline_executor());
    grid.spread(sites, std::vector<double>{2, 0.5});
    grid.forward();
    grid.for_waves([&](auto coefficients, const WaveGrid::Wave& wave, std::size_t) {
        if (wave.number != 0) return;
        EXPECT_NEAR(std::abs(coefficients[0]) / wave.window, 2.5, 1e-5);
    });
}

TEST(WaveGrid, GivesTheSameBitsForAnyNumberOfThreads) {
    const std::vector<Point3> sites = points(5000);
    ThreadExecutor threads(3);
    // An odd and an even number of slabs of layers.
    for (const double layers : {24.0, 32.0}) {
        for (const bool periodic : {true, false}) {
            WaveGrid one({kSides, periodic}, {40, 40, layers}, inline_executor());
            WaveGrid three({kSides, periodic}, {40, 40, layers}, threads);
            for (WaveGrid* grid : {&one, &three}) {
                grid->spread(sites, {});
                grid->forward();
                grid->backward();
            }
            EXPECT_TRUE(std::ranges::equal(one.values(), three.values()));
        }
    }
}

}  // namespace
}  // namespace ccdt
