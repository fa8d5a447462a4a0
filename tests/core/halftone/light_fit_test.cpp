// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/light_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/ccdt.h"
#include "core/halftone/blur.h"
#include "core/halftone/dot_fit.h"
#include "core/halftone/separation.h"
#include "core/halftone/two_sided.h"

namespace ccdt {
namespace {

constexpr CellGrid kCells = {96, 96};
constexpr std::size_t kCount = 96 * 96;
constexpr std::size_t kSites = 1500;
const InkSet kRiso{{{1, 0.06F, 0.43F}, {0, 0.19F, 0.52F}, {1, 0.81F, 0}, {0, 0, 0}}};

using Colour = std::array<float, 3>;
using Sites = std::vector<std::vector<Point>>;

/// Plans a picture whose left half has one colour and whose right half has another one.
TwoSidedPlan plan_of_halves(const Colour& left, const Colour& right) {
    std::array<Plane, 3> planes;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto values = std::make_shared<float[]>(kCount);
        for (std::size_t i = 0; i < kCount; ++i)
            values[static_cast<std::ptrdiff_t>(i)] = i % 96 < 48 ? left[c] : right[c];
        planes[c] = Plane(values, kCount);
    }
    Separation inks = separate({kCells.columns, kCells.rows, planes[0], planes[1], planes[2], {}}, kRiso, Tone::Linear);
    return plan_two_sided({std::move(inks.coverage), std::move(inks.light)}, kRiso, kCells, {kSites, {}, 0, 0});
}

Sites placed(const TwoSidedPlan& plan) {
    std::vector<Density> densities;
    std::vector<double> shares;
    for (const KindOfDots& kind : plan.kinds) {
        densities.push_back(Density::grid(plan.dot_cells.columns, plan.dot_cells.rows, std::span(kind.density))
                                .value_or(Density::uniform()));
        shares.push_back(kind.share);
    }
    const auto domain = Domain::rectangle(kCells.columns, kCells.rows);
    Sites sites;
    const auto distributed = distribute_inks(*domain, densities, share_sites(shares, kSites), {});
    for (const Distribution& each : *distributed) sites.push_back(each.points);
    return sites;
}

/// Draws dots, and returns the mean light of each cell.
/// @param colours  [sets of inks] printed light
LightPlanes drawn(const TwoSidedPlan& plan, const std::vector<Colour>& colours, const Sites& sites,
                  const std::vector<SizedDots>& dots) {
    constexpr int kScale = 6, kWidth = 96 * kScale;
    std::vector<unsigned> flipped(static_cast<std::size_t>(kWidth) * kWidth, 0);
    const auto for_pixels_of = [&](Point centre, double radius, const auto& work) {
        const auto first = [&](double middle) { return std::max(static_cast<int>((middle - radius) * kScale), 0); };
        const auto last = [&](double middle) {
            return std::min(static_cast<int>((middle + radius) * kScale), kWidth - 1);
        };
        for (int y = first(centre.y); y <= last(centre.y); ++y) {
            for (int x = first(centre.x); x <= last(centre.x); ++x) {
                const Point way = Point{(x + 0.5) / kScale, (y + 0.5) / kScale} - centre;
                if (dot(way, way) <= radius * radius) work(static_cast<std::size_t>(y * kWidth + x));
            }
        }
    };
    for (std::size_t kind = 0; kind < sites.size(); ++kind) {
        for (std::size_t i = 0; i < sites[kind].size(); ++i)
            for_pixels_of(sites[kind][i], static_cast<double>(dots[kind].radii[i]),
                          [&](std::size_t pixel) { flipped[pixel] |= plan.kinds[kind].flips; });
    }
    LightPlanes light;
    for (std::vector<float>& each : light) each.resize(kCount, 0);
    for (int y = 0; y < kWidth; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            unsigned inks = flipped[static_cast<std::size_t>(y * kWidth + x)];
            for (std::size_t c = 0; c < plan.channels.size(); ++c) {
                const Point place{(x + 0.5) / kScale, (y + 0.5) / kScale};
                inks ^= static_cast<unsigned>(!plan.channels[c].ground.is_white(place)) << c;
            }
            const auto cell = static_cast<std::size_t>(y / kScale * kCells.columns + x / kScale);
            for (std::size_t c = 0; c < 3; ++c) light[c][cell] += colours[inks][c] / (kScale * kScale);
        }
    }
    return light;
}

/// Returns the mean error of light after a blur of one spacing.
double error_of(const LightPlanes& light, const TwoSidedPlan& plan) {
    const CellGrid& cells = plan.dot_cells;
    const auto count = static_cast<std::size_t>(cells.columns * cells.rows);
    const double spacing = std::sqrt(static_cast<double>(count) / kSites);
    std::vector<float> scratch;
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        std::vector<float> error = reduced(light[c], kCells.columns, kCells.rows, cells);
        for (std::size_t i = 0; i < count; ++i) error[i] -= plan.wanted[c][i];
        for (int step = 0; step < 2; ++step)
            blur(error, cells.columns, cells.rows, spacing / std::sqrt(2), scratch, inline_executor());
        for (const float each : error) sum += static_cast<double>(std::abs(each));
    }
    return sum / (3 * static_cast<double>(count));
}

/// Two colours with different grounds.
constexpr Colour kReddish = {0.4F, 0.1F, 0.1F}, kBluish = {0.1F, 0.3F, 0.4F};

TEST(LightFit, IsCloserToPictureThanFitOfEachInk) {
    TwoSidedPlan plan = plan_of_halves(kReddish, kBluish);
    const Sites sites = placed(plan);
    const std::vector<Colour> colours = plan.colours;
    const auto error = [&] { return error_of(drawn(plan, colours, sites, size_dots(plan, sites, true)), plan); };
    const double by_light = error();
    plan.colours.clear();
    const double by_ink = error();
    EXPECT_LT(by_light, 0.0065) << "is 0.0053 if light is fitted, and 0.0074 if hidden dots are planned large";
    EXPECT_GT(by_ink, 2 * by_light) << "is 0.0159 if the cover of each ink is fitted";
}

TEST(LightFit, NeedsNoLargerDotsOnGroundThatHidesThem) {
    for (const auto& [left, right] : {std::pair(kReddish, kBluish),
                                      {{0.25F, 0.06F, 0.02F}, {0.5F, 0.45F, 0.35F}},
                                      {{0.5F, 0.4F, 0.1F}, {0.05F, 0.1F, 0.05F}}}) {
        const TwoSidedPlan plan = plan_of_halves(left, right);
        const auto shows = [&](std::size_t cell, unsigned flips) {
            constexpr float kLeast = 0.02F;
            const unsigned ground = black_channels(plan, cell);
            float most = 0;
            for (std::size_t c = 0; c < 3; ++c)
                most = std::max(most, std::abs(plan.colours[ground ^ flips][c] - plan.colours[ground][c]));
            return most > kLeast;
        };
        const auto reach = static_cast<std::size_t>(std::ceil(plan.radius * plan.scale().x));
        const auto columns = static_cast<std::size_t>(plan.dot_cells.columns);
        int found = 0;
        float largest = 0;
        for (const KindOfDots& kind : plan.kinds) {
            for (std::size_t i = reach; i + reach < kind.density.size(); ++i) {
                if (i % columns < reach || i % columns + reach >= columns) continue;
                if (!(kind.density[i] > 0) || shows(i, kind.flips)) continue;
                for (const std::size_t other : {i - reach, i + reach}) {
                    if (!(kind.density[other] > 0) || !shows(other, kind.flips)) continue;
                    ++found;
                    largest = std::max(largest, kind.area[i] / kind.area[other]);
                }
            }
        }
        EXPECT_GT(found, 0);
        EXPECT_LT(largest, 1.5F);
    }
}

}  // namespace
}  // namespace ccdt
