// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/two_sided.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/halftone/dot_plan.h"
#include "core/halftone/flip_share.h"
#include "core/halftone/ink_grounds.h"
#include "core/halftone/mixed_kinds.h"
#include "core/halftone/nested_kinds.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/sharpening.h"

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;

/// Number of dots and range of their areas.
struct DotScale {
    double dots = 0;     ///< number
    double unit = 0;     ///< area of the largest dots, in cells
    float min_area = 0;  ///< area of the smallest dots, relative to the largest
};

/// Computes the number of dots and the range of their areas. The area of the largest dots and the relative area of the
/// smallest dots depend on each other, so the function iterates.
/// @param kinds  `area` is relative to the largest dot; `density` is the covered share
DotScale scale_of(std::span<const KindOfDots> kinds, const TwoSidedOptions& options, Executor& executor) {
    constexpr float kMinArea = 0.05f;
    constexpr int kRounds = 3;
    DotScale scale;
    scale.min_area = kMinArea;
    for (int round = 0; round < kRounds; ++round) {
        double units = 0;
        for (const KindOfDots& kind : kinds) {
            units += sum_of_pixels(executor, kind.area.size(), [&](std::size_t i) {
                return static_cast<double>(kind.density[i] / std::max(kind.area[i], scale.min_area));
            });
        }
        scale.unit = options.radius ? std::max(kPi * *options.radius * *options.radius, kMinDotArea)
                                    : units / static_cast<double>(*options.sites);
        if (options.max_sites) scale.unit = std::max(scale.unit, units / static_cast<double>(*options.max_sites));
        if (!(scale.unit > 0)) return {};
        scale.dots = units / scale.unit;
        const double wanted = kPi * options.min_radius * options.min_radius / scale.unit;
        scale.min_area = static_cast<float>(std::clamp(wanted, static_cast<double>(kMinArea), 1.0));
    }
    return scale;
}

/// Returns the requested radius, or the radius of the requested number of dots of equal size, in cells.
double mean_radius(std::span<const std::vector<float>> light, const TwoSidedOptions& options, Executor& executor) {
    if (options.radius) return *options.radius;
    return std::sqrt(minority_area(light, executor) / (kPi * static_cast<double>(*options.sites)));
}

/// Returns a plan that contains the grounds of a picture, but no dots.
TwoSidedPlan with_grounds(std::vector<std::vector<float>> light, const CellGrid& cells, double radius, double detail,
                          bool is_rgb, Executor& executor) {
    TwoSidedPlan plan;
    plan.cells = cells;
    std::vector<Ground> grounds = divide_ground(light, cells, radius, detail, is_rgb, executor);
    for (std::size_t c = 0; c < light.size(); ++c)
        plan.channels.push_back({std::move(grounds[c]), std::move(light[c]), {}});
    return plan;
}

/// Converts covered shares to densities and relative areas to areas in cells. Sets TwoSidedPlan::dots and radius.
void set_scale(TwoSidedPlan& plan, const TwoSidedOptions& options, Executor& executor) {
    const DotScale scale = scale_of(plan.kinds, options, executor);
    plan.dots = scale.dots;
    plan.radius = std::sqrt(scale.unit / kPi);
    for (KindOfDots& kind : plan.kinds) {
        for_pixels(executor, kind.area.size(), [&](std::size_t i) {
            const float area = std::max(kind.area[i], scale.min_area);
            kind.density[i] /= area;
            kind.area[i] = area * static_cast<float>(scale.unit);
        });
        kind.share = sum_of_pixels(executor, kind.density.size(),
                                   [&](std::size_t i) { return static_cast<double>(kind.density[i]); });
    }
}

}  // namespace

double minority_area(std::span<const std::vector<float>> light, Executor& executor) {
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
        share.push_back(flip_share(sharp.back(), channel.white, cells, executor));
        clear_thin_ground(channel.white, cells, radius, share.back(), executor);
    }
    if (stop.stop_requested()) return plan;
    add_nested_kinds(plan, share, sharp, radius, executor);
    set_scale(plan, options, executor);
    return plan;
}

TwoSidedPlan plan_two_sided(InkPicture picture, const InkSet& inks, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop, Executor& executor) {
    assert(options.sites || options.radius);
    assert(picture.coverage.size() == inks.inks.size());
    constexpr int kMaxRepairs = 2;
    std::vector<std::vector<float>> bare = std::move(picture.coverage);
    for (std::vector<float>& ink : bare) for_pixels(executor, ink.size(), [&](std::size_t i) { ink[i] = 1 - ink[i]; });
    const double radius = mean_radius(bare, options, executor);
    InkGrounds grounds(inks, picture.light, executor);
    grounds.reduce_cover(bare);
    TwoSidedPlan plan;
    for (int repairs = 0; repairs <= kMaxRepairs; ++repairs) {
        plan = with_grounds(bare, cells, radius, options.detail, false, executor);
        for (TwoSidedChannel& channel : plan.channels) channel.white = channel.ground.white_shares(executor);
        if (stop.stop_requested() || repairs == kMaxRepairs || !grounds.replace_grounds(bare, plan)) break;
    }
    plan.is_nested = false;
    // With three inks, fit_light() increases some errors, for example of astronaut.png after a blur of two pitches.
    constexpr std::size_t kMinInksOfLightFit = 4;
    const std::size_t sets = inks.inks.size() < kMinInksOfLightFit ? 0 : std::size_t{1} << inks.inks.size();
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
    set_scale(plan, options, executor);
    return plan;
}

}  // namespace ccdt
