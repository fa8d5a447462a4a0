// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/field_drawing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/plane/ccdt.h"
#include "core/picture/blur.h"
#include "core/picture/tone.h"

namespace ccdt {
namespace {

constexpr int kColumns = 180, kRows = 120, kScale = 3;
constexpr CellGrid kCells{kColumns, kRows};

using Light = std::vector<std::vector<float>>;

std::vector<float> picture(const auto& light) {
    std::vector<float> values;
    for (int y = 0; y < kRows; ++y) {
        for (int x = 0; x < kColumns; ++x) values.push_back(static_cast<float>(light(x + 0.5, y + 0.5)));
    }
    return values;
}

std::vector<float> flat(double light) {
    return picture([light](double, double) { return light; });
}

FieldDrawing draw(const FieldPlan& plan, std::optional<int> scale = kScale) {
    std::vector<Point> sites;
    if (plan.sites > 0) {
        Options options;
        options.sites = static_cast<std::size_t>(plan.sites);
        const auto density = Density::grid(kColumns, kRows, std::span<const float>(plan.density));
        sites = distribute(*Domain::rectangle(kColumns, kRows), *density, options)->points;
    }
    std::optional<CellGrid> canvas;
    if (scale) canvas = {*scale * kColumns, *scale * kRows};
    return {plan, sites, canvas};
}

std::vector<float> light_of(const Raster& raster) {
    std::vector<float> light;
    for (const std::uint8_t ink : raster.coverage) light.push_back(1 - static_cast<float>(ink) / 255);
    return light;
}

double mean(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Returns the standard deviation of lightness (0 to 1) after a blur.
double grain(const Raster& raster, double sigma) {
    // A single blur has side lobes, which let a part of the dots' texture pass.
    auto lights = light_of(raster);
    for (int half = 0; half < 2; ++half)
        lights = blurred(std::move(lights), raster.width, raster.height, sigma / std::numbers::sqrt2);
    for (float& light : lights) light = lightness(std::clamp(light, 0.0f, 1.0f));
    const double middle = mean(lights);
    double squares = 0;
    for (const float light : lights) squares += (light - middle) * (light - middle);
    return std::sqrt(squares / static_cast<double>(lights.size()));
}

TEST(FieldDrawing, PreservesToneOfFlatGreysWithoutGrain) {
    for (const double light : {0.014, 0.1, 0.3, 0.45, 0.5, 0.6, 0.8, 0.94}) {
        const FieldPlan plan = plan_field({flat(light)}, kCells, {2000, {}, 0});
        const FieldDrawing drawing = draw(plan);
        const double pitch = kScale * plan.pitch();
        for (const bool antialias : {true, false}) {
            const Raster raster = drawing.rasters(kScale * kColumns, kScale * kRows, antialias).at(0);
            EXPECT_NEAR(mean(light_of(raster)), light, 0.001) << light << antialias;
            EXPECT_LT(grain(raster, pitch), antialias ? 0.0005 : light < 0.1 ? 0.02 : 0.006) << light << antialias;
        }
    }
}

TEST(FieldDrawing, HasNoSeamInRamp) {
    const FieldPlan plan =
        plan_field({picture([](double x, double) { return 0.3 + 0.4 * x / kColumns; })}, kCells, {2000, {}, 0});
    const Raster raster = draw(plan).rasters(kScale * kColumns, kScale * kRows, true).at(0);
    const auto seen = blurred(light_of(raster), raster.width, raster.height, 1.5 * kScale * plan.pitch());
    for (int x = 60; x < raster.width - 60; ++x) {
        const double wanted = 0.3 + 0.4 * (x + 0.5) / raster.width;
        EXPECT_NEAR(seen[static_cast<std::size_t>(raster.height / 2 * raster.width + x)], wanted, 0.003) << x;
    }
}

TEST(FieldDrawing, DrawsBlackAndWhiteWithoutSpecks) {
    // Discs and bars, beside a grey that needs sites.
    const auto art = picture([](double x, double y) {
        if (x > 150) return 0.5;
        const bool disc = std::hypot(x - 40, y - 40) < 25, ring = std::hypot(x - 40, y - 40) < 12;
        const bool bar = y > 80 && static_cast<int>(x) % 12 < 4;
        return (disc && !ring) || bar ? 0.0 : 1.0;
    });
    for (const std::size_t sites : {300, 2000, 20'000}) {
        const FieldPlan plan = plan_field({art}, kCells, {sites, {}, 1});
        for (const bool antialias : {true, false}) {
            const Raster raster = draw(plan).rasters(kScale * kColumns, kScale * kRows, antialias).at(0);
            int wrong = 0;
            for (int y = 2; y < kRows - 2; ++y) {
                for (int x = 2; x < 140; ++x) {
                    // Cells whose surroundings have one colour.
                    const auto at = [&](int column, int row) {
                        return art[static_cast<std::size_t>(row * kColumns + column)];
                    };
                    bool same = true;
                    for (int dy = -2; dy <= 2; ++dy) {
                        for (int dx = -2; dx <= 2; ++dx) same = same && at(x + dx, y + dy) == at(x, y);
                    }
                    if (!same) continue;
                    const auto middle = static_cast<std::size_t>((kScale * y + 1) * raster.width + kScale * x + 1);
                    if (raster.coverage[middle] != (at(x, y) == 0 ? 255 : 0)) ++wrong;
                }
            }
            EXPECT_EQ(wrong, 0) << sites << antialias;
        }
    }
}

TEST(FieldDrawing, DrawsObjectsWithoutFrameAndGhost) {
    constexpr double kLight = 0.3, kLeft = 40, kRight = 140, kTop = 30, kBottom = 90;
    const FieldPlan plan = plan_field(
        {picture([&](double x, double y) { return x > kLeft && x < kRight && y > kTop && y < kBottom ? kLight : 1; })},
        kCells, {2000, {}, 1});
    const Raster raster = draw(plan).rasters(kScale * kColumns, kScale * kRows, true).at(0);
    // Mean light at a distance from the object's sides, in cells, negative within the object.
    const auto lights = light_of(raster);
    const auto at = [&](double from, double to) {
        double sum = 0, count = 0;
        for (int y = 0; y < raster.height; ++y) {
            for (int x = 0; x < raster.width; ++x) {
                const double across = std::max(kLeft - (x + 0.5) / kScale, (x + 0.5) / kScale - kRight);
                const double along = std::max(kTop - (y + 0.5) / kScale, (y + 0.5) / kScale - kBottom);
                const double distance = std::max(across, along);
                if (distance < from || distance > to) continue;
                sum += static_cast<double>(lights[static_cast<std::size_t>(y * raster.width + x)]);
                ++count;
            }
        }
        return sum / count;
    };
    EXPECT_EQ(at(1, 30), 1);
    EXPECT_NEAR(at(-1.5, -0.5), kLight, 0.1);
    EXPECT_NEAR(at(-3, -1.5), kLight, 0.1);
    EXPECT_NEAR(at(-20, -3), kLight, 0.01);
}

TEST(FieldDrawing, DrawsTheSameTonesOnAnyCanvas) {
    const auto waves = picture([](double x, double y) { return 0.5 + 0.4 * std::sin(x / 15) * std::cos(y / 11); });
    const FieldPlan plan = plan_field({waves}, kCells, {500, {}, 0});
    for (const int scale : {1, 2, 6}) {
        const FieldDrawing drawing = draw(plan, scale);
        const Raster raster = drawing.rasters(scale * kColumns, scale * kRows, true).at(0);
        const auto seen = blurred(light_of(raster), raster.width, raster.height, 1.5 * scale * plan.pitch());
        const auto wanted = blurred(waves, kColumns, kRows, 1.5 * plan.pitch());
        for (int y = 0; y < kRows; y += 7) {
            for (int x = 0; x < kColumns; x += 7) {
                const std::size_t at =
                    static_cast<std::size_t>((scale * y + scale / 2) * raster.width + scale * x + scale / 2);
                EXPECT_NEAR(seen[at], wanted[static_cast<std::size_t>(y * kColumns + x)], 0.02) << scale;
            }
        }
    }
}

TEST(FieldDrawing, HasOutlinesOfTheSameArea) {
    const FieldPlan plan =
        plan_field({picture([](double x, double) { return 0.05 + 0.9 * x / kColumns; })}, kCells, {800, {}, 0});
    const FieldDrawing drawing = draw(plan, {});
    for (const bool lighter : {false, true}) {
        double area = 0;
        const auto outlines = drawing.outlines(lighter);
        for (const auto& ring : outlines.at(0)) {
            for (std::size_t i = 0; i < ring.size(); ++i) area += cross(ring[i], ring[(i + 1) % ring.size()]) / 2;
        }
        EXPECT_NEAR(std::abs(area), 0.5, 0.003) << lighter;
    }
}

TEST(FieldDrawing, NestsTheSetsOfInks) {
    const InkSet inks{{{0, 0.19F, 0.52F}, {1, 0.06F, 0.43F}, {1, 0.81F, 0}}};
    const auto light = picture([](double x, double y) { return 0.2 + 0.6 * x * y / (kColumns * kRows); });
    const FieldPlan plan = plan_field({light, flat(0.4), light}, inks, kCells, {2000, {}, 0});
    const FieldDrawing drawing = draw(plan);
    for (const bool antialias : {true, false}) {
        const auto rasters = drawing.rasters(kScale * kColumns, kScale * kRows, antialias);
        ASSERT_EQ(rasters.size(), plan.channels.size());
        for (std::size_t c = 0; c < rasters.size(); ++c) {
            EXPECT_NEAR(mean(light_of(rasters[c])), mean(plan.channels[c].light), 0.003) << c;
            const Raster& before = rasters[c > 0 ? c - 1 : 0];
            EXPECT_TRUE(std::ranges::equal(before.coverage, rasters[c].coverage, std::less_equal{})) << c;
        }
    }
}

TEST(FieldDrawing, AcceptsSmallestPictures) {
    for (const float light : {0.0f, 0.3f, 1.0f}) {
        const FieldPlan plan = plan_field(Light{{light}}, {1, 1}, {1, {}, 1});
        for (const int side : {1, 9}) {
            const FieldDrawing drawing(plan, std::vector<Point>(plan.sites > 0 ? 1 : 0, Point{0.5, 0.5}),
                                       CellGrid{side, side});
            EXPECT_NEAR(mean(light_of(drawing.rasters(side, side, true).at(0))), light, side > 1 ? 0.02 : 0.1);
        }
    }
}

}  // namespace
}  // namespace ccdt
