// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/two_sided.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/halftone/dot_plan.h"
#include "core/halftone/ink_grounds.h"
#include "core/halftone/mixed_kinds.h"
#include "core/halftone/nested_kinds.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/sharpening.h"
#include "core/halftone/wanted_share.h"

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;

/// Settles the number of dots, the area of the largest, and that of the smallest over it.
struct Scale {
    double dots = 0;
    double unit = 0;  ///< area of a dot of relative area 1, in cells
    float least = 0;  ///< relative area of the smallest dots
};

/// @param kinds  with their shares as densities
Scale settle(std::span<const KindOfDots> kinds, const TwoSidedOptions& options, Executor& executor) {
    constexpr float kLeastArea = 0.05f;
    constexpr int kRounds = 3;
    Scale scale;
    scale.least = kLeastArea;
    for (int round = 0; round < kRounds; ++round) {
        double units = 0;
        for (const KindOfDots& kind : kinds) {
            units += sum_of_pixels(executor, kind.area.size(), [&](std::size_t i) {
                return static_cast<double>(kind.density[i] / std::max(kind.area[i], scale.least));
            });
        }
        scale.unit = options.radius ? std::max(kPi * *options.radius * *options.radius, kLeastDotArea)
                                    : units / static_cast<double>(*options.sites);
        if (options.most) scale.unit = std::max(scale.unit, units / static_cast<double>(*options.most));
        if (!(scale.unit > 0)) return {};
        scale.dots = units / scale.unit;
        const double least = kPi * options.least_radius * options.least_radius / scale.unit;
        scale.least = static_cast<float>(std::clamp(least, static_cast<double>(kLeastArea), 1.0));
    }
    return scale;
}

/// Radius that dots would have if all had one size, in cells.
double mean_radius(std::span<const std::vector<float>> light, const TwoSidedOptions& options, Executor& executor) {
    if (options.radius) return *options.radius;
    const double minority = minority_of(light, executor);
    return std::sqrt(minority / (kPi * static_cast<double>(*options.sites)));
}

/// Divides a picture into grounds.
TwoSidedPlan with_grounds(std::vector<std::vector<float>> light, const CellGrid& cells, double radius, double detail,
                          bool is_rgb, Executor& executor) {
    TwoSidedPlan plan;
    plan.cells = cells;
    std::vector<Ground> grounds = divide_ground(light, cells, radius, detail, is_rgb, executor);
    for (std::size_t c = 0; c < light.size(); ++c)
        plan.channels.push_back({std::move(grounds[c]), std::move(light[c]), {}});
    return plan;
}

/// Settles the number and the areas of dots, whose shares and relative areas a plan has.
void settle(TwoSidedPlan& plan, const TwoSidedOptions& options, Executor& executor) {
    const Scale scale = settle(plan.kinds, options, executor);
    plan.dots = scale.dots;
    plan.radius = std::sqrt(scale.unit / kPi);
    for (KindOfDots& kind : plan.kinds) {
        for_pixels(executor, kind.area.size(), [&](std::size_t i) {
            const float area = std::max(kind.area[i], scale.least);
            kind.density[i] /= area;
            kind.area[i] = area * static_cast<float>(scale.unit);
        });
        kind.share = sum_of_pixels(executor, kind.density.size(),
                                   [&](std::size_t i) { return static_cast<double>(kind.density[i]); });
    }
}

}  // namespace

double minority_of(std::span<const std::vector<float>> light, Executor& executor) {
    return sum_of_pixels(executor, light.front().size(), [&](std::size_t i) {
        float most = 0;
        for (const auto& channel : light) most = std::max(most, std::min(channel[i], 1 - channel[i]));
        return static_cast<double>(most);
    });
}

TwoSidedPlan plan_two_sided(std::vector<std::vector<float>> light, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop, Executor& executor) {
    assert(options.sites || options.radius);
    assert(light.size() == 1 || light.size() == 3);
    const double radius = mean_radius(light, options, executor);
    const bool is_rgb = light.size() > 1;
    TwoSidedPlan plan = with_grounds(std::move(light), cells, radius, options.detail, is_rgb, executor);
    std::vector<std::vector<float>> sharp, share;
    for (TwoSidedChannel& channel : plan.channels) {
        if (stop.stop_requested()) return plan;
        sharp.push_back(sharpened(channel.light, cells.columns, cells.rows, options.detail * radius, executor));
        channel.white = channel.ground.white_shares(executor);
        share.push_back(wanted_share(sharp.back(), channel.white, cells, executor));
        spare_thin_ground(channel.white, cells, radius, share.back(), executor);
    }
    if (stop.stop_requested()) return plan;
    add_nested_kinds(plan, share, sharp, radius, executor);
    settle(plan, options, executor);
    return plan;
}

TwoSidedPlan plan_two_sided(InkPicture picture, const InkSet& inks, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop, Executor& executor) {
    assert(options.sites || options.radius);
    assert(picture.coverage.size() == inks.inks.size());
    constexpr int kMostRepairs = 2;
    std::vector<std::vector<float>> bare = std::move(picture.coverage);
    for (std::vector<float>& ink : bare) for_pixels(executor, ink.size(), [&](std::size_t i) { ink[i] = 1 - ink[i]; });
    const double radius = mean_radius(bare, options, executor);
    InkGrounds grounds(inks, picture.light, executor);
    grounds.settle(bare);
    TwoSidedPlan plan;
    for (int repairs = 0; repairs <= kMostRepairs; ++repairs) {
        plan = with_grounds(bare, cells, radius, options.detail, false, executor);
        for (TwoSidedChannel& channel : plan.channels) channel.white = channel.ground.white_shares(executor);
        if (stop.stop_requested() || repairs == kMostRepairs || !grounds.repair(bare, plan)) break;
    }
    plan.is_nested = false;
    // With three inks, some errors grow when light is fitted: a few at half a pitch, and for astronaut.png the 95th
    // percentile at two pitches.
    constexpr std::size_t kLeastInksOfLight = 4;
    const std::size_t sets = inks.inks.size() < kLeastInksOfLight ? 0 : std::size_t{1} << inks.inks.size();
    if (sets > 0) plan.wanted = picture.light;
    for (std::size_t set = 0; set < sets; ++set) {
        std::vector<float> cover;
        for (std::size_t ink = 0; ink < inks.inks.size(); ++ink) cover.push_back(static_cast<float>(set >> ink & 1));
        const Light light = printed(inks, cover);
        plan.colours.push_back({light.red, light.green, light.blue});
    }
    if (stop.stop_requested()) return plan;
    add_mixed_kinds(plan, inks, std::move(picture.light), radius, options.detail * radius, stop, executor);
    if (stop.stop_requested()) return plan;
    settle(plan, options, executor);
    return plan;
}

}  // namespace ccdt
