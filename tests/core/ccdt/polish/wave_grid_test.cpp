// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/wave_grid.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/base/thread_executor.h"

namespace ccdt {
namespace {

constexpr double kTau = 6.283185307179586;
constexpr double kError = 3e-4;            // error that the header documents
constexpr double kHighestFrequency = 0.2;  // up to this frequency, in cycles per cell

struct Weighted {
    Point position;
    double value;
};

std::vector<Weighted> random_points(Point sides, std::size_t count) {
    Random random(1, count);
    std::vector<Weighted> points(count);
    for (Weighted& p : points) {
        p = {{sides.x * random.uniform(), sides.y * random.uniform()}, 2 * random.uniform() - 0.5};
    }
    return points;
}

void spread(WaveGrid& grid, Point p, double value) {
    grid.spread(std::span(&p, 1), std::span(&value, 1));
}

Point gradient(const WaveGrid& grid, Point p) {
    grid.gradients(std::span(&p, 1), std::span(&p, 1));
    return p;
}

/// Returns the sum over points of value e^(-i 2 pi f.p). In a box, sums value cos(2 pi f_x x) cos(2 pi f_y y) over the
/// four mirror images of each point.
std::complex<double> direct_sum(const WaveGrid& grid, bool torus, const std::vector<Weighted>& points, Point f) {
    std::complex<double> sum;
    for (const auto& [p, value] : points) {
        if (torus) {
            sum += value * std::polar(1.0, -kTau * dot(f, p));
        } else {
            sum += grid.copies() * value * std::cos(kTau * f.x * p.x) * std::cos(kTau * f.y * p.y);
        }
    }
    return sum;
}

/// Returns the largest error of the documented frequencies, relative to the sum of the values' magnitudes.
double largest_error(WaveGrid& grid, bool torus, const std::vector<Weighted>& points) {
    grid.clear();
    double magnitude = 0;
    for (const auto& [position, value] : points) {
        spread(grid, position, value);
        magnitude += grid.copies() * std::abs(value);
    }
    grid.transform();
    double largest = 0;
    std::size_t compared = 0;
    grid.with_coefficients([&](auto coefficients) {
        grid.for_waves([&](std::size_t number, const WaveGrid::Wave& wave) {
            const Point f = grid.frequency(wave);
            if (std::hypot(f.x * grid.cell().x, f.y * grid.cell().y) > kHighestFrequency) return;
            ++compared;
            const std::complex<double> found = coefficients[number] / grid.window(wave);
            largest = std::max(largest, std::abs(found - direct_sum(grid, torus, points, f)) / magnitude);
        });
    });
    EXPECT_GT(compared, 20u);
    return largest;
}

TEST(WaveGrid, SumsWavesOnATorus) {
    for (const Point sides : {Point{1, 1}, Point{1, 0.375}}) {
        WaveGrid grid(true, sides, {32, 24, 1});
        EXPECT_LT(largest_error(grid, true, random_points(sides, 1)), kError);
        EXPECT_LT(largest_error(grid, true, random_points(sides, 50)), kError);
    }
}

TEST(WaveGrid, SumsWavesInABox) {
    for (const Point sides : {Point{1, 1}, Point{0.375, 1}}) {
        WaveGrid grid(false, sides, {32, 24, 1});
        EXPECT_LT(largest_error(grid, false, random_points(sides, 1)), kError);
        EXPECT_LT(largest_error(grid, false, random_points(sides, 50)), kError);
    }
}

TEST(WaveGrid, SumsWavesOfPointsOnItsSides) {
    const Point sides{1, 0.75};
    const double below = std::nextafter(0.75, 0.0), most = std::nextafter(1.0, 0.0);
    const std::vector<Weighted> points{{{0, 0}, 1},     {{1, 0.75}, 1},     {{0, 0.75}, 2},      {{1, 0.3}, 0.5},
                                       {{0.2, 0}, 1.5}, {{most, below}, 1}, {{1e-300, below}, 1}};
    for (const bool torus : {true, false}) {
        WaveGrid grid(torus, sides, {32, 24, 1});
        EXPECT_LT(largest_error(grid, torus, points), kError) << torus;
        for (const Weighted& point : points) EXPECT_LT(largest_error(grid, torus, {point}), kError) << torus;
    }
}

TEST(WaveGrid, AcceptsAnyPeriodicCopyOfAPoint) {
    // The last point is so little below 0 that its position in the period rounds to the upper end.
    const std::vector<Weighted> around{{{-0.25, 1.5}, 1}, {{1.75, -0.875}, 1}, {{-1, 2}, 1}, {{-1e-18, -1e-18}, 1}};
    WaveGrid grid(true, {1, 1}, {30, 30, 1});
    EXPECT_LT(largest_error(grid, true, around), kError);
}

TEST(WaveGrid, PreservesTheSumOfSpreadValues) {
    for (const bool torus : {true, false}) {
        WaveGrid grid(torus, {1, 0.5}, {16, 8, 1});
        const auto points = random_points({1, 0.5}, 100);
        double total = 0;
        grid.clear();
        for (const auto& [position, value] : points) {
            spread(grid, position, value);
            total += value;
        }
        grid.transform();
        grid.with_coefficients(
            [&](auto coefficients) { EXPECT_NEAR(std::abs(coefficients[0]), grid.copies() * total, 1e-12 * total); });
    }
}

TEST(WaveGrid, HasTheGradientOfAWave) {
    const Point sides{1, 0.75};
    for (const bool torus : {true, false}) {
        for (const auto& [i, j] : {std::pair{1, 1}, {3, 2}, {5, 1}}) {
            WaveGrid grid(torus, sides, {32, 24, 1});
            grid.with_coefficients([&, i = i, j = j](auto coefficients) {
                for (auto& coefficient : coefficients) coefficient = 0;
                coefficients[grid.number({i, j, 0})] = 1 / grid.window({i, j, 0});
            });
            grid.transform_back();
            const Point f = kTau * grid.frequency({i, j, 0});
            auto points = random_points(sides, 100);
            for (const Point p : {Point{0, 0}, Point{1, 0.75}, Point{0, 0.75}, Point{1, 0}}) points.push_back({p, 1});
            for (const auto& [p, value] : points) {
                // A coefficient of 1 represents 2 cos(f.p) on a torus and 4 cos(f_x x) cos(f_y y) in a box.
                const Point along = -2 * std::sin(dot(f, p)) * f;
                const Point mirrored{-4 * f.x * std::sin(f.x * p.x) * std::cos(f.y * p.y),
                                     -4 * f.y * std::cos(f.x * p.x) * std::sin(f.y * p.y)};
                const Point wanted = torus ? along : mirrored, found = gradient(grid, p);
                const double steepest = 4 * std::sqrt(dot(f, f));
                EXPECT_NEAR(found.x, wanted.x, 1e-3 * steepest) << torus << ' ' << i << ' ' << j;
                EXPECT_NEAR(found.y, wanted.y, 1e-3 * steepest) << torus << ' ' << i << ' ' << j;
            }
        }
    }
}

TEST(WaveGrid, SpreadsMoves) {
    for (const bool torus : {true, false}) {
        WaveGrid grid(torus, {1, 0.5}, {40, 20, 1});
        const auto points = random_points({1, 0.5}, 30);
        const auto spread_moved = [&](double share) {
            grid.clear();
            for (const auto& [position, value] : points) spread(grid, position + share * Point{value, 1 - value}, 1);
            grid.transform();
            return grid.grid()[7] + 2 * grid.grid()[333];
        };
        constexpr double kStep = 1e-5;
        const double slope = (spread_moved(kStep) - spread_moved(-kStep)) / (2 * kStep);
        grid.clear();
        for (const auto& [position, value] : points)
            grid.spread_moves(std::vector{position}, std::vector{Point{value, 1 - value}});
        grid.transform();
        EXPECT_NEAR(grid.grid()[7] + 2 * grid.grid()[333], slope, 1e-4 * std::abs(slope)) << torus;
    }
}

/// Processors with AVX2 handle two points at once.
TEST(WaveGrid, IsIdenticalForBatchesAndSinglePoints) {
    const Point sides{2, 0.7};
    auto points = random_points(sides, 301);
    for (const Point p :
         {Point{0, 0}, Point{2, 0.7}, Point{0, 0.7}, Point{2, 0}, Point{-0.0, 0.35}, Point{1e-308, 0.1}})
        points.push_back({p, 1});
    std::vector<Point> positions;
    std::vector<double> values;
    for (const auto& [position, value] : points) {
        positions.push_back(position);
        values.push_back(value);
    }
    for (const bool torus : {false, true}) {
        WaveGrid each(torus, sides, {36, 16, 1}), many(torus, sides, {36, 16, 1});
        each.clear();
        many.clear();
        for (const auto& [position, value] : points) spread(each, position, value);
        many.spread(positions, values);
        for (WaveGrid* const grid : {&each, &many}) grid->transform();
        each.with_coefficients([&](auto coefficients) {
            many.with_coefficients([&](auto others) {
                if constexpr (std::is_same_v<decltype(coefficients), decltype(others)>) {
                    EXPECT_TRUE(std::ranges::equal(coefficients, others)) << torus;
                }
            });
        });
        each.transform_back();
        std::vector<Point> gradients(positions.size());
        each.gradients(positions, gradients);
        for (std::size_t i = 0; i < positions.size(); ++i)
            EXPECT_EQ(gradients[i], gradient(each, positions[i])) << torus;
    }
}

TEST(WaveGrid, SpreadsManyPointsOnAnyNumberOfThreads) {
    Random random(5, 0);
    std::vector<Point> points(30'000), moves(points.size());
    std::vector<double> values(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i] = {2 * random.uniform(), random.uniform()};
        moves[i] = {random.uniform(), random.uniform()};
        values[i] = i % 3 == 0 ? 0 : random.uniform();
    }
    for (const bool torus : {false, true}) {
        const auto cells_of = [&](Executor& executor, auto&& spread) {
            WaveGrid grid(torus, {2, 1}, {160, 90, 1}, executor);
            grid.clear();
            spread(grid);
            grid.transform();
            grid.backward();
            return std::vector<double>(grid.grid().begin(), grid.grid().end());
        };
        const auto each = cells_of(inline_executor(), [&](WaveGrid& grid) {
            for (std::size_t i = 0; i < points.size(); ++i) {
                spread(grid, points[i], values[i]);
                grid.spread_moves(std::span(points).subspan(i, 1), std::span(moves).subspan(i, 1));
            }
        });
        const auto all = [&](WaveGrid& grid) {
            grid.spread(points, values);
            grid.spread_moves(points, moves);
        };
        const auto alone_all = cells_of(inline_executor(), all);
        for (std::size_t i = 0; i < each.size(); ++i) ASSERT_NEAR(alone_all[i], each[i], 1e-4);
        for (const std::size_t size : {2, 16}) {
            ThreadExecutor executor(size);
            EXPECT_EQ(cells_of(executor, all), alone_all);
        }
    }
}

}  // namespace
}  // namespace ccdt
