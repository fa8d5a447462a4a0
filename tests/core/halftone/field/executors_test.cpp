// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <tuple>
#include <vector>

#include "core/base/thread_executor.h"
#include "core/halftone/dots/dots.h"
#include "core/halftone/field/dot_plan.h"
#include "core/halftone/field/field_drawing.h"
#include "core/halftone/field/field_plan.h"
#include "core/halftone/inks/print_proof.h"
#include "core/halftone/inks/separation.h"
#include "core/picture/blur.h"
#include "core/picture/fineness.h"
#include "core/picture/levels.h"
#include "core/picture/reduction.h"
#include "core/picture/sharpening.h"
#include "core/picture/tone.h"
#include "tests/support/inks.h"

namespace ccdt {
namespace {

/// More pixels than are summed sequentially (kPixelsOfSum), and not a multiple of any range.
constexpr int kWidth = 1301, kHeight = 907;

Plane waves(double frequency) {
    const auto values = std::make_shared<float[]>(kWidth * kHeight);
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x)
            values[y * kWidth + x] = static_cast<float>(0.5 + 0.5 * std::sin(frequency * (x + 0.3 * y) + 1e-4 * x * y));
    }
    return {values, kWidth * kHeight};
}

std::vector<float> values_of(const Plane& plane) {
    return {plane.begin(), plane.end()};
}

std::vector<Point> lattice() {
    std::vector<Point> points;
    for (int i = 0; i < 4001; ++i)
        points.push_back({std::fmod(i * 0.618033988749895, 1) * kWidth, i * kHeight / 4001.0});
    return points;
}

/// Checks that executors with any number of threads give the same result as the inline executor.
template <class Make>
void expect_same(const Make& make) {
    const auto expected = make(inline_executor());
    for (const std::size_t threads : {2, 3, 16}) {
        ThreadExecutor executor(threads);
        EXPECT_TRUE(make(executor) == expected) << threads << " threads";
    }
}

TEST(Executors, GiveTheSameDrawingByOneField) {
    constexpr CellGrid kCells{kWidth, kHeight};
    const std::vector<std::vector<float>> light{values_of(waves(0.05)), values_of(waves(0.06)), values_of(waves(0.08))};
    expect_same([&](Executor& executor) {
        const FieldPlan plan = plan_field(light, kCells, {4001, {}, 0.7, 3}, {}, executor);
        const FieldDrawing drawing(plan, lattice(), CellGrid{kWidth / 2, kHeight / 2}, {}, executor);
        std::vector<std::vector<std::uint8_t>> coverage;
        for (const bool antialias : {true, false}) {
            for (const Raster& raster : drawing.rasters(kWidth / 2, kHeight / 2, antialias))
                coverage.push_back(raster.coverage);
        }
        return std::tuple(plan.density, coverage, FieldDrawing(plan, lattice(), {}, {}, executor).outlines());
    });
}

TEST(Executors, GiveTheSamePlanOfInks) {
    const LightPlanes light{values_of(waves(0.05)), values_of(waves(0.06)), values_of(waves(0.08))};
    InkSet inks = test::cmyk_inks();
    inks.inks.push_back({1, 0.4F, 0.1F});
    expect_same([&](Executor& executor) {
        const FieldPlan plan = plan_field(light, inks, {kWidth, kHeight}, {4001, {}, 0.7}, {}, executor);
        return std::tuple(plan.density, plan.sets, plan.channels.back().light);
    });
}

TEST(Executors, GiveTheSameBlurAndSharpening) {
    const std::vector<float> values = values_of(waves(0.05));
    for (const double sigma : {0.7, 5.0, 300.0}) {
        expect_same([&](Executor& executor) { return blurred(values, kWidth, kHeight, sigma, executor); });
        expect_same([&](Executor& executor) { return sharpened(values, kWidth, kHeight, sigma, executor); });
    }
    expect_same([&](Executor& executor) { return blurred(values, kHeight, kWidth, 2, executor); });
    expect_same([&](Executor& executor) { return blurred(values, kWidth * kHeight, 1, 2, executor); });
    expect_same([&](Executor& executor) { return blurred(values, 1, kWidth * kHeight, 2, executor); });
}

TEST(Executors, GiveTheSameDotPlans) {
    const std::vector<std::vector<float>> cover = {values_of(waves(0.05)), values_of(waves(0.013))};
    for (const DotRequest& request : {DotRequest{.sites = 5000, .radius = {}, .detail = 1},
                                      DotRequest{.sites = {}, .radius = 4.0, .detail = 0.5}}) {
        expect_same([&](Executor& executor) {
            const DotPlan plan = plan_dots(cover, kWidth, kHeight, request, {}, executor);
            return std::tuple(plan.radius, plan.tone, plan.density, plan.dots);
        });
    }
}

TEST(Executors, GiveTheSameTones) {
    const Picture picture{kWidth, kHeight, waves(0.4), waves(0.02)};
    const ColourPicture colours{kWidth, kHeight, waves(0.4), waves(0.03), waves(0.01), waves(0.02)};
    for (const Tone tone : {Tone::Linear, Tone::Perceptual})
        expect_same([&](Executor& executor) { return ink_coverage(picture, tone, false, executor); });
    expect_same([&](Executor& executor) { return fineness(picture, executor); });
    expect_same([&](Executor& executor) { return fineness(colours, executor); });
    const Levels levels{.black = 0.1, .white = 0.9, .gamma = 2};
    expect_same([&](Executor& executor) { return with_levels(picture, levels, executor).luminance; });
    expect_same([&](Executor& executor) { return with_levels(colours, levels, executor).blue; });
}

TEST(Executors, GiveTheSameMeans) {
    const std::vector<float> values = values_of(waves(0.4));
    const ColourPicture colours{kWidth, kHeight, waves(0.4), waves(0.03), waves(0.01), waves(0.02)};
    for (const CellGrid& cells : {CellGrid{kWidth, kHeight}, CellGrid{434, 303}, CellGrid{97, 61}, CellGrid{1, 1}}) {
        expect_same([&](Executor& executor) { return reduced(values, kWidth, kHeight, cells, executor); });
        expect_same([&](Executor& executor) {
            const ColourPicture small = reduced(colours, cells, executor);
            return std::tuple(small.red, small.green, small.blue, small.alpha);
        });
    }
}

TEST(Executors, GiveTheSameSeparation) {
    const ColourPicture colours{kWidth, kHeight, waves(0.4), waves(0.03), waves(0.01), waves(0.02)};
    expect_same([&](Executor& executor) {
        const Separation separation = separate(colours, test::cmyk_inks(), Tone::Linear, {}, executor);
        return std::tuple(separation.coverage, separation.light);
    });
}

TEST(Executors, GiveTheSameRasters) {
    const std::vector<Point> dots = lattice();
    const Canvas canvas{kWidth, kHeight, 1};
    for (const DotOptions& options :
         {DotOptions{.mean_coverage = 0.4}, DotOptions{.mean_coverage = 0.4, .antialias = true},
          DotOptions{.radius = 9.0}, DotOptions{.radius = 9.0, .antialias = true},
          DotOptions{.radius = 300.0, .antialias = true, .samples = 1},
          DotOptions{.radius = 9.0, .antialias = true, .samples = 1}, DotOptions{.radius = 1.2, .samples = 2}}) {
        expect_same([&](Executor& executor) {
            const Raster raster = draw_dots(dots, canvas, options, {}, executor);
            return std::tuple(raster.radius, raster.coverage);
        });
    }
}

TEST(Executors, GiveTheSameMovesOfInks) {
    const LightPlanes light = {values_of(waves(0.03)), values_of(waves(0.02)), values_of(waves(0.01))};
    const std::vector<std::vector<Point>> sites(4, lattice());
    expect_same([&](Executor& executor) {
        const PrintProof proof(light, {kWidth, kHeight}, kWidth, kHeight, test::cmyk_inks(), 9, 16'004, executor);
        std::vector<double> moves;
        for (const auto& ink : proof.moves(sites, {}, executor)) {
            for (const Point& move : ink) moves.insert(moves.end(), {move.x, move.y});
        }
        EXPECT_TRUE(std::ranges::any_of(moves, [](double move) { return move != 0; }));
        return moves;
    });
}

}  // namespace
}  // namespace ccdt
