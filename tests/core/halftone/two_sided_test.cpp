// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/two_sided.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/ccdt.h"
#include "core/halftone/blur.h"
#include "core/halftone/dot_fit.h"
#include "core/halftone/dots.h"
#include "core/halftone/separation.h"
#include "core/halftone/tone.h"

namespace ccdt {
namespace {

constexpr int kScale = 6;

using Planes = std::vector<std::vector<float>>;

struct Drawing {
    TwoSidedPlan plan;
    std::vector<std::vector<Point>> sites;  ///< [kinds]
    std::vector<SizedDots> dots;            ///< [kinds]
    Planes light;                           ///< [channels][pixels] on a canvas of kScale pixels per cell
};

/// Draws the dots of one channel.
std::vector<float> print(const Drawing& drawing, std::size_t channel) {
    const CellGrid& cells = drawing.plan.cells;
    std::vector<Point> points;
    std::vector<float> radii;
    for (std::size_t kind = 0; kind < drawing.sites.size(); ++kind) {
        if ((flips_of(kind) >> channel & 1) == 0) continue;
        points.insert(points.end(), drawing.sites[kind].begin(), drawing.sites[kind].end());
        radii.insert(radii.end(), drawing.dots[kind].radii.begin(), drawing.dots[kind].radii.end());
    }
    const Canvas canvas{cells.columns * kScale, cells.rows * kScale, kScale};
    Raster raster = draw_dots(points, radii, canvas, true, 1);
    drawing.plan.channels[channel].ground.apply(raster, {kScale, kScale}, true);
    std::vector<float> light;
    for (const std::uint8_t ink : raster.coverage) light.push_back(1 - static_cast<float>(ink) / 255);
    return light;
}

Drawing draw(Planes light, const CellGrid& cells, std::size_t sites, bool fit = true) {
    Drawing drawing{plan_two_sided(std::move(light), cells, {sites, {}, 0, 0}), {}, {}, {}};
    const auto domain = Domain::rectangle(cells.columns, cells.rows);
    std::vector<Density> densities;
    std::vector<double> shares;
    const CellGrid& dot_cells = drawing.plan.dot_cells;
    for (const KindOfDots& kind : drawing.plan.kinds) {
        densities.push_back(
            Density::grid(dot_cells.columns, dot_cells.rows, std::span(kind.density)).value_or(Density::uniform()));
        shares.push_back(kind.share);
    }
    const auto placed = distribute_inks(*domain, densities, share_sites(shares, sites), {});
    for (const Distribution& each : *placed) drawing.sites.push_back(each.points);
    drawing.dots = size_dots(drawing.plan, drawing.sites, fit);
    for (std::size_t c = 0; c < drawing.plan.channels.size(); ++c) drawing.light.push_back(print(drawing, c));
    return drawing;
}

std::vector<float> flat(const CellGrid& cells, float light) {
    return std::vector<float>(static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows), light);
}

double mean_of(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Applies an approximate Gaussian blur in two steps. The side lobes of a single step would pass the pattern of dots.
std::vector<float> smoothed(const std::vector<float>& values, int width, int height, double sigma) {
    return blurred(blurred(values, width, height, sigma / std::sqrt(2)), width, height, sigma / std::sqrt(2));
}

/// Returns the standard deviation of L* after a blur of one spacing, away from the border.
double grain(const Drawing& drawing, std::size_t sites) {
    const CellGrid cells = drawing.plan.cells;
    const int width = cells.columns * kScale, height = cells.rows * kScale;
    const double pitch = std::sqrt(static_cast<double>(width) * height / static_cast<double>(sites));
    const auto seen = smoothed(drawing.light.front(), width, height, pitch);
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

TEST(TwoSided, PreservesToneOfFlatGreysWithoutGrain) {
    constexpr CellGrid kCells = {80, 80};
    constexpr std::size_t kSites = 1500;
    for (const float light : {0.014F, 0.05F, 0.1F, 0.3F, 0.49F, 0.51F, 0.8F, 0.94F}) {
        const Drawing drawing = draw({flat(kCells, light)}, kCells, kSites);
        const double mean = mean_of(drawing.light.front());
        EXPECT_NEAR(mean, static_cast<double>(light), 0.002) << light;
        EXPECT_LT(grain(drawing, kSites), 0.12) << light;
        const std::uint8_t white = light > 0.5F ? 1 : 0;
        EXPECT_TRUE(std::ranges::all_of(drawing.dots.front().white, [&](std::uint8_t each) { return each == white; }));
    }
}

TEST(TwoSided, HasNoSeamWhereGroundChanges) {
    constexpr CellGrid kCells = {160, 60};
    constexpr std::size_t kSites = 2400;
    std::vector<float> ramp;
    for (int i = 0; i < kCells.columns * kCells.rows; ++i)
        ramp.push_back(0.2F + 0.6F * (static_cast<float>(i % kCells.columns) + 0.5F) / kCells.columns);
    const Drawing drawing = draw({ramp}, kCells, kSites);
    const int width = kCells.columns * kScale, height = kCells.rows * kScale;
    const double pitch = std::sqrt(static_cast<double>(width) * height / kSites);
    const auto seen = smoothed(drawing.light.front(), width, height, pitch);
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

TEST(TwoSided, CorrectsToneAlongBoundary) {
    constexpr CellGrid kCells = {120, 120};
    constexpr std::size_t kSites = 2000;
    std::vector<float> waves;
    for (int y = 0; y < kCells.rows; ++y) {
        for (int x = 0; x < kCells.columns; ++x)
            waves.push_back(0.5F + 0.15F * static_cast<float>(std::sin(x / 7.0) + std::sin((x + 2 * y) / 11.0)));
    }
    const auto error = [&](bool fit) {
        const Drawing drawing = draw({waves}, kCells, kSites, fit);
        const int side = kCells.columns * kScale;
        const double pitch = side / std::sqrt(static_cast<double>(kSites));
        const auto seen = smoothed(drawing.light.front(), side, side, pitch);
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

TEST(TwoSided, NeedsNoDotsForBlackAndWhite) {
    constexpr CellGrid kCells = {40, 40};
    std::vector<float> halves;
    for (int i = 0; i < kCells.columns * kCells.rows; ++i) halves.push_back(i % kCells.columns < 20 ? 0.0F : 1.0F);
    const TwoSidedPlan plan = plan_two_sided({halves}, kCells, {100, {}, 0.7, 0});
    EXPECT_EQ(plan.dots, 0);
    EXPECT_FALSE(plan.channels.front().ground.is_white({19.9, 20}));
    EXPECT_TRUE(plan.channels.front().ground.is_white({20.1, 20}));
}

TEST(TwoSided, ShrinksDotsInShadowsDownToMinimumRadius) {
    constexpr CellGrid kCells = {80, 40};
    std::vector<float> light;
    for (int i = 0; i < kCells.columns * kCells.rows; ++i) light.push_back(i % kCells.columns < 40 ? 0.02F : 0.4F);
    const auto smallest = [&](double least) {
        const TwoSidedPlan plan = plan_two_sided({light}, kCells, {400, {}, 0, least});
        return std::pair(std::sqrt(*std::ranges::min_element(plan.kinds.front().area) / 3.14159F), plan.radius);
    };
    const auto [radius, largest] = smallest(0);
    EXPECT_LT(radius, 0.5 * largest);
    EXPECT_GT(smallest(0.6).first, 0.57F);
}

TEST(TwoSided, DerivesNumberOfDotsFromRadius) {
    constexpr CellGrid kCells = {64, 64};
    const auto grey = flat(kCells, 0.5F);
    const TwoSidedPlan plan = plan_two_sided({grey}, kCells, {{}, 1.0, 0, 0});
    EXPECT_NEAR(plan.dots, 0.5 * 64 * 64 / 3.14159, 5);
    EXPECT_DOUBLE_EQ(plan.radius, 1.0);
}

TEST(TwoSided, AcceptsTinyRadius) {
    constexpr CellGrid kCells = {8, 8};
    const double dots = plan_two_sided({flat(kCells, 0.5F)}, kCells, {{}, 1e-308, 0, 0}).dots;
    EXPECT_GT(dots, 1e12);
    EXPECT_TRUE(std::isfinite(dots));
}

TEST(TwoSided, AcceptsPicturesOfOnePixel) {
    for (const float light : {0.0F, 0.3F, 1.0F}) {
        const TwoSidedPlan plan = plan_two_sided({{light}}, {1, 1}, {1, {}, 1, 0});
        const std::vector<std::vector<Point>> site = {{{0.5, 0.5}}};
        const std::vector<SizedDots> dots = size_dots(plan, site, true);
        ASSERT_EQ(dots.front().radii.size(), 1U);
        EXPECT_TRUE(std::isfinite(dots.front().radii.front()));
    }
}

/// Returns three channels with different waves, so that each channel is the lightest and the darkest one somewhere.
Planes colours(const CellGrid& cells) {
    Planes light(3);
    for (int y = 0; y < cells.rows; ++y) {
        for (int x = 0; x < cells.columns; ++x) {
            for (int c = 0; c < 3; ++c) {
                const double wave = std::sin(x / (9.0 + 2 * c)) * std::sin((y + 20 * c) / 13.0);
                light[static_cast<std::size_t>(c)].push_back(static_cast<float>(0.5 + 0.48 * wave));
            }
        }
    }
    return light;
}

/// Returns the area that the dots of all kinds flip in each channel of a cell.
/// @param covered  out: total area of the dots
std::array<float, 3> flipped_in(const TwoSidedPlan& plan, std::size_t cell, float& covered) {
    std::array<float, 3> flipped{};
    covered = 0;
    for (std::size_t kind = 0; kind < plan.kinds.size(); ++kind) {
        const float share = plan.kinds[kind].density[cell] * plan.kinds[kind].area[cell];
        covered += share;
        for (std::size_t c = 0; c < 3; ++c) {
            if ((flips_of(kind) >> c & 1) != 0) flipped[c] += share;
        }
    }
    return flipped;
}

TEST(TwoSided, NestsFlippedChannels) {
    constexpr CellGrid kCells = {120, 90};
    const Planes light = colours(kCells);
    const TwoSidedPlan plan = plan_two_sided(light, kCells, {3000, {}, 0, 0});
    ASSERT_EQ(plan.kinds.size(), 7U);
    // Densities are relative: an area is a share of the cell after division by that of the largest dots.
    const double unit = std::numbers::pi * plan.radius * plan.radius;
    double off = 0;
    for (std::size_t i = 0; i < plan.channels.front().light.size(); ++i) {
        float covered = 0;
        const auto flipped = flipped_in(plan, i, covered);
        EXPECT_LE(covered / unit, 0.58) << i;
        EXPECT_NEAR(covered, *std::ranges::max_element(flipped), 1e-4 * unit) << "flipped areas are nested";
        EXPECT_LE(std::ranges::count_if(plan.kinds, [&](const auto& kind) { return kind.density[i] > 0; }), 3) << i;
        for (std::size_t c = 0; c < 3; ++c) {
            const float wanted = std::abs(plan.channels[c].white[i] - plan.channels[c].light[i]);
            off += std::abs(static_cast<double>(flipped[c]) / unit - static_cast<double>(wanted));
        }
    }
    EXPECT_LT(off / static_cast<double>(3 * plan.channels.front().light.size()), 0.01)
        << "only cells at a boundary or on thin ground differ";
}

TEST(TwoSided, PreservesMeanOfEachChannel) {
    constexpr CellGrid kCells = {100, 100};
    for (const auto& colour : {std::array{0.01F, 0.03F, 0.09F}, std::array{0.6F, 0.2F, 0.05F},
                               std::array{0.9F, 0.5F, 0.3F}, std::array{0.45F, 0.45F, 0.45F}}) {
        const Drawing drawing =
            draw({flat(kCells, colour[0]), flat(kCells, colour[1]), flat(kCells, colour[2])}, kCells, 2500);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(mean_of(drawing.light[c]), static_cast<double>(colour[c]), 0.003)
                << colour[0] << " channel " << c;
    }
}

TEST(TwoSided, FollowsEachChannel) {
    constexpr CellGrid kCells = {120, 90};
    constexpr std::size_t kSites = 3000;
    const Planes light = colours(kCells);
    const Drawing drawing = draw(light, kCells, kSites);
    const int width = kCells.columns * kScale, height = kCells.rows * kScale;
    const double pitch = std::sqrt(static_cast<double>(width) * height / kSites);
    for (std::size_t c = 0; c < 3; ++c) {
        std::vector<float> wanted(drawing.light[c].size());
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const std::size_t x = i % static_cast<std::size_t>(width) / kScale;
            const std::size_t y = i / static_cast<std::size_t>(width) / kScale;
            wanted[i] = light[c][y * kCells.columns + x];
        }
        wanted = smoothed(wanted, width, height, 2 * pitch);
        const auto seen = smoothed(drawing.light[c], width, height, 2 * pitch);
        double sum = 0;
        for (std::size_t i = 0; i < seen.size(); ++i) sum += std::abs(static_cast<double>(seen[i] - wanted[i]));
        EXPECT_LT(sum / static_cast<double>(seen.size()), 0.006) << c;
    }
}

TEST(TwoSided, DrawsGreysWithDotsFlippingAllChannels) {
    constexpr CellGrid kCells = {60, 60};
    std::vector<float> grey;
    for (int i = 0; i < kCells.columns * kCells.rows; ++i)
        grey.push_back(0.5F + 0.4F * std::sin(static_cast<float>(i % kCells.columns) / 9));
    const TwoSidedPlan colour = plan_two_sided({grey, grey, grey}, kCells, {900, {}, 0.7, 0});
    const TwoSidedPlan alone = plan_two_sided({grey}, kCells, {900, {}, 0.7, 0});
    for (std::size_t kind = 0; kind + 1 < colour.kinds.size(); ++kind) EXPECT_EQ(colour.kinds[kind].share, 0) << kind;
    EXPECT_NEAR(colour.radius, alone.radius, 1e-6 * alone.radius);
    for (const TwoSidedChannel& channel : colour.channels) EXPECT_EQ(channel.white, alone.channels.front().white);
    for (std::size_t i = 0; i < alone.kinds.front().density.size(); ++i)
        EXPECT_NEAR(colour.kinds.back().density[i], alone.kinds.front().density[i], 1e-3F) << i;
}

TEST(TwoSided, DistributesDotsEvenlyPerKindAndTogether) {
    constexpr CellGrid kCells = {100, 100};
    constexpr std::size_t kSites = 3000;
    // The ground is red. Dots add green, or green and blue.
    const Drawing drawing = draw({flat(kCells, 0.95F), flat(kCells, 0.4F), flat(kCells, 0.2F)}, kCells, kSites);
    std::vector<Point> all;
    const auto nearest_mean = [&](const std::vector<Point>& points) {
        const double spacing =
            std::sqrt(2 / std::sqrt(3.0) * kCells.columns * kCells.rows / static_cast<double>(points.size()));
        double sum = 0;
        for (const Point& a : points) {
            double least = std::numeric_limits<double>::max();
            for (const Point& b : points) {
                if (&a != &b) least = std::min(least, dot(a - b, a - b));
            }
            sum += std::sqrt(least);
        }
        return sum / static_cast<double>(points.size()) / spacing;
    };
    for (const auto& sites : drawing.sites) {
        all.insert(all.end(), sites.begin(), sites.end());
        if (sites.size() < 200) continue;
        EXPECT_GT(nearest_mean(sites), 0.8) << sites.size();
    }
    EXPECT_EQ(all.size(), kSites);
    EXPECT_GT(nearest_mean(all), 0.7);
}

}  // namespace
}  // namespace ccdt
