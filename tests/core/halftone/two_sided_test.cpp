#include "core/halftone/two_sided.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/ccdt.h"
#include "core/halftone/blur.h"
#include "core/halftone/dots.h"
#include "core/halftone/tone.h"

namespace ccdt {
namespace {

constexpr int kScale = 6;

struct Drawing {
    TwoSidedPlan plan;
    std::vector<Point> sites;
    SidedDots dots;
    std::vector<float> light;  ///< [pixels] of a canvas of kScale pixels a cell
};

Drawing draw(std::vector<float> light, const CellGrid& cells, std::size_t sites, bool fit = true) {
    Drawing drawing{plan_two_sided(std::move(light), cells, {sites, {}, 0, 0}), {}, {}, {}};
    const auto domain = Domain::rectangle(cells.columns, cells.rows);
    const auto density = Density::grid(cells.columns, cells.rows, std::span(drawing.plan.density));
    Options options;
    options.sites = sites;
    drawing.sites = distribute(*domain, *density, options)->points;
    drawing.dots = size_dots(drawing.plan, drawing.sites, fit);
    const Canvas canvas{cells.columns * kScale, cells.rows * kScale, kScale};
    Raster raster = draw_dots(drawing.sites, drawing.dots.radii, canvas, true, 1);
    drawing.plan.ground.apply(raster, {kScale, kScale}, true);
    for (const std::uint8_t ink : raster.coverage) drawing.light.push_back(1 - static_cast<float>(ink) / 255);
    return drawing;
}

std::vector<float> flat(const CellGrid& cells, float light) {
    return std::vector<float>(static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows), light);
}

/// Blurs by nearly a Gaussian: twice, lest the side lobes of box filters let the pattern through.
std::vector<float> smoothed(const std::vector<float>& values, int width, int height, double sigma) {
    return blurred(blurred(values, width, height, sigma / std::sqrt(2)), width, height, sigma / std::sqrt(2));
}

/// Standard deviation of L* after a blur of one pitch, away from the border.
double grain(const Drawing& drawing, std::size_t sites) {
    const CellGrid cells = drawing.plan.cells;
    const int width = cells.columns * kScale, height = cells.rows * kScale;
    const double pitch = std::sqrt(static_cast<double>(width) * height / static_cast<double>(sites));
    const auto seen = smoothed(drawing.light, width, height, pitch);
    const int margin = static_cast<int>(4 * pitch);
    double sum = 0, squares = 0, count = 0;
    for (int y = margin; y < height - margin; ++y) {
        for (int x = margin; x < width - margin; ++x) {
            const double value =
                100 *
                static_cast<double>(lightness(
                    seen[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)]));
            sum += value;
            squares += value * value;
            ++count;
        }
    }
    return std::sqrt(std::max(squares / count - sum / count * (sum / count), 0.0));
}

TEST(TwoSided, KeepsTheToneOfFlatGreysWithoutGrain) {
    constexpr CellGrid kCells = {80, 80};
    constexpr std::size_t kSites = 1500;
    for (const float light : {0.014F, 0.05F, 0.1F, 0.3F, 0.49F, 0.51F, 0.8F, 0.94F}) {
        const Drawing drawing = draw(flat(kCells, light), kCells, kSites);
        const double mean = std::accumulate(drawing.light.begin(), drawing.light.end(), 0.0) /
                            static_cast<double>(drawing.light.size());
        EXPECT_NEAR(mean, static_cast<double>(light), 0.002) << light;
        EXPECT_LT(grain(drawing, kSites), 0.12) << light;
        const Side side = light > 0.5F ? Side::Ink : Side::Paper;
        EXPECT_TRUE(std::ranges::all_of(drawing.dots.sides, [&](Side each) { return each == side; })) << light;
    }
}

TEST(TwoSided, ShowsNoSeamWhereTheGroundChanges) {
    constexpr CellGrid kCells = {160, 60};
    constexpr std::size_t kSites = 2400;
    std::vector<float> ramp;
    for (int i = 0; i < kCells.columns * kCells.rows; ++i)
        ramp.push_back(0.2F + 0.6F * (static_cast<float>(i % kCells.columns) + 0.5F) / kCells.columns);
    const Drawing drawing = draw(ramp, kCells, kSites);
    const int width = kCells.columns * kScale, height = kCells.rows * kScale;
    const double pitch = std::sqrt(static_cast<double>(width) * height / kSites);
    const auto seen = smoothed(drawing.light, width, height, pitch);
    const auto error_within = [&](double from, double to) {
        double sum = 0, count = 0;
        for (int y = height / 8; y < height * 7 / 8; ++y) {
            for (int x = static_cast<int>(from * width); x < to * width; ++x) {
                const auto wanted = static_cast<float>(0.2 + 0.6 * (x + 0.5) / width);
                const auto pixel =
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
                sum += std::abs(100 * static_cast<double>(lightness(seen[pixel]) - lightness(wanted)));
                ++count;
            }
        }
        return sum / count;
    };
    EXPECT_LT(error_within(0.45, 0.55), 0.3);
    EXPECT_LT(error_within(0.1, 0.9), 0.12);
}

TEST(TwoSided, CorrectsTheToneAlongTheBoundary) {
    constexpr CellGrid kCells = {120, 120};
    constexpr std::size_t kSites = 2000;
    std::vector<float> waves;
    for (int y = 0; y < kCells.rows; ++y) {
        for (int x = 0; x < kCells.columns; ++x)
            waves.push_back(0.5F + 0.15F * static_cast<float>(std::sin(x / 7.0) + std::sin((x + 2 * y) / 11.0)));
    }
    const auto error = [&](bool fit) {
        const Drawing drawing = draw(waves, kCells, kSites, fit);
        const int side = kCells.columns * kScale;
        const double pitch = side / std::sqrt(static_cast<double>(kSites));
        const auto seen = smoothed(drawing.light, side, side, pitch);
        std::vector<float> wanted(seen.size());
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const std::size_t x = i % static_cast<std::size_t>(side) / kScale;
            const std::size_t y = i / static_cast<std::size_t>(side) / kScale;
            wanted[i] = waves[y * kCells.columns + x];
        }
        wanted = smoothed(wanted, side, side, pitch);
        double sum = 0;
        for (std::size_t i = 0; i < seen.size(); ++i) sum += std::abs(static_cast<double>(seen[i] - wanted[i]));
        return sum / static_cast<double>(seen.size());
    };
    EXPECT_LT(error(true), 0.4 * error(false));
}

TEST(TwoSided, LeavesNothingToDotsWhereThePictureIsBlackAndWhite) {
    constexpr CellGrid kCells = {40, 40};
    std::vector<float> halves;
    for (int i = 0; i < kCells.columns * kCells.rows; ++i) halves.push_back(i % kCells.columns < 20 ? 0.0F : 1.0F);
    const TwoSidedPlan plan = plan_two_sided(halves, kCells, {100, {}, 0.7, 0});
    EXPECT_EQ(plan.dots, 0);
    EXPECT_FALSE(plan.ground.is_white({19.9, 20}));
    EXPECT_TRUE(plan.ground.is_white({20.1, 20}));
}

TEST(TwoSided, MakesDotsSmallerInShadowsButNoneBelowTheLeastRadius) {
    constexpr CellGrid kCells = {80, 40};
    std::vector<float> light;
    for (int i = 0; i < kCells.columns * kCells.rows; ++i) light.push_back(i % kCells.columns < 40 ? 0.02F : 0.4F);
    const auto smallest = [&](double least) {
        const TwoSidedPlan plan = plan_two_sided(light, kCells, {400, {}, 0, least});
        return std::pair(std::sqrt(*std::ranges::min_element(plan.area) / 3.14159F), plan.radius);
    };
    const auto [radius, largest] = smallest(0);
    EXPECT_LT(radius, 0.5 * largest);
    EXPECT_GT(smallest(0.6).first, 0.57F);
}

TEST(TwoSided, CountsTheDotsOfARadius) {
    constexpr CellGrid kCells = {64, 64};
    const auto grey = flat(kCells, 0.5F);
    const TwoSidedPlan plan = plan_two_sided(grey, kCells, {{}, 1.0, 0, 0});
    EXPECT_NEAR(plan.dots, 0.5 * 64 * 64 / 3.14159, 5);
    EXPECT_DOUBLE_EQ(plan.radius, 1.0);
}

TEST(TwoSided, CountsDotsOfNextToNoRadius) {
    constexpr CellGrid kCells = {8, 8};
    const double dots = plan_two_sided(flat(kCells, 0.5F), kCells, {{}, 1e-308, 0, 0}).dots;
    EXPECT_GT(dots, 1e12);
    EXPECT_TRUE(std::isfinite(dots));
}

TEST(TwoSided, TakesPicturesOfOnePixel) {
    for (const float light : {0.0F, 0.3F, 1.0F}) {
        const TwoSidedPlan plan = plan_two_sided({light}, {1, 1}, {1, {}, 1, 0});
        const std::vector<Point> site = {{0.5, 0.5}};
        const SidedDots dots = size_dots(plan, site, true);
        ASSERT_EQ(dots.radii.size(), 1U);
        EXPECT_TRUE(std::isfinite(dots.radii.front()));
    }
}

}  // namespace
}  // namespace ccdt
