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
/// @param plan  its kinds have areas relative to the largest dot, and covered shares in place of densities
DotScale scale_of(const TwoSidedPlan& plan, const TwoSidedOptions& options, Executor& executor) {
    constexpr float kMinArea = 0.05f;
    constexpr int kRounds = 3;
    DotScale scale;
    scale.min_area = kMinArea;
    for (int round = 0; round < kRounds; ++round) {
        double units = 0;
        for (const KindOfDots& kind : plan.kinds) {
            units += sum_of_pixels(executor, kind.area.size(), [&](std::size_t i) {
                return static_cast<double>(kind.density[i] / std::max(kind.area[i], scale.min_area));
            });
        }
        units *= plan.dot_cell_area();
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

/// Returns a plan that contains the grounds of a picture, but no dots. Its dot cells equal its cells.
TwoSidedPlan with_grounds(std::span<const std::vector<float>> light, const CellGrid& cells, double radius,
                          double detail, bool is_rgb, Executor& executor) {
    TwoSidedPlan plan;
    plan.cells = plan.dot_cells = cells;
    for (Ground& ground : divide_ground(light, cells, radius, detail, is_rgb, executor))
        plan.channels.push_back({std::move(ground), {}, {}});
    return plan;
}

/// Computes the share of white ground in each dot cell.
void find_white_shares(TwoSidedPlan& plan, Executor& executor) {
    for (TwoSidedChannel& channel : plan.channels)
        channel.white = channel.ground.white_shares(plan.dot_cells, executor);
}

/// Chooses dot cells whose side is at most half the spacing of nearly all dots. The side is at most 1/64 of the shorter
/// side of the picture.
///
/// Measured on eleven photographs and pages with 2,000 to 60,000 dots: nine dots of ten have a spacing of at least 2.7
/// mean radii. With 1.3 cells per spacing instead of 2, the grain of flat greys is six times as large.
/// @param radius  radius that dots would have if all had the same size, in cells
CellGrid dot_cells_of(const CellGrid& cells, double radius) {
    constexpr double kSide = 1.35;  // radii
    constexpr double kFewest = 64;
    const double side = std::max(std::min(kSide * radius, std::min(cells.columns, cells.rows) / kFewest), 1.0);
    return {static_cast<int>(std::ceil(cells.columns / side)), static_cast<int>(std::ceil(cells.rows / side))};
}

/// Returns the standard deviation, in dot cells, of the blur that sharpening compensates. Besides the blur by dots, it
/// contains that of the means over dot cells, and that of the constant density in a dot cell, each with the variance of
/// a box.
/// @param radius  mean radius of the dots, in dot cells
double blur_of(const TwoSidedPlan& plan, double detail, double radius) {
    constexpr double kBoxes = 2.0 / 12;
    return detail * std::sqrt(radius * radius + (plan.dot_cells == plan.cells ? 0 : kBoxes));
}

/// Returns the means of a picture's light over the dot cells of a plan.
std::vector<float> in_dot_cells(const TwoSidedPlan& plan, std::vector<float> light, Executor& executor) {
    if (plan.dot_cells == plan.cells) return light;
    return reduced(light, plan.cells.columns, plan.cells.rows, plan.dot_cells, executor);
}

/// Converts covered shares to densities and relative areas to areas in cells. Sets TwoSidedPlan::dots and radius.
void set_scale(TwoSidedPlan& plan, const TwoSidedOptions& options, Executor& executor) {
    const DotScale scale = scale_of(plan, options, executor);
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
    TwoSidedPlan plan = with_grounds(light, cells, radius, options.detail, is_rgb, executor);
    plan.dot_cells = dot_cells_of(cells, radius);
    find_white_shares(plan, executor);
    const double own_radius = radius / std::sqrt(plan.dot_cell_area());  // in dot cells
    std::vector<std::vector<float>> sharp, share;
    for (std::size_t c = 0; c < light.size(); ++c) {
        if (stop.stop_requested()) return plan;
        TwoSidedChannel& channel = plan.channels[c];
        channel.light = in_dot_cells(plan, std::move(light[c]), executor);
        sharp.push_back(sharpened(channel.light, plan.dot_cells.columns, plan.dot_cells.rows,
                                  blur_of(plan, options.detail, own_radius), executor));
        share.push_back(flip_share(sharp.back(), channel.white, plan.dot_cells, executor));
        clear_thin_ground(channel.white, plan.dot_cells, own_radius, share.back(), executor);
    }
    if (stop.stop_requested()) return plan;
    add_nested_kinds(plan, share, sharp, own_radius, executor);
    set_scale(plan, options, executor);
    return plan;
}

TwoSidedPlan plan_two_sided(InkPicture picture, const InkSet& inks, const CellGrid& cells,
                            const TwoSidedOptions& options, const std::stop_token& stop, Executor& executor) {
    assert(options.sites || options.radius);
    assert(picture.coverage.size() == inks.inks.size());
    constexpr int kMaxRepairs = 1;
    std::vector<std::vector<float>> bare = std::move(picture.coverage);
    for (std::vector<float>& ink : bare) for_pixels(executor, ink.size(), [&](std::size_t i) { ink[i] = 1 - ink[i]; });
    const double radius = mean_radius(bare, options, executor);
    InkGrounds grounds(inks, picture.light, executor);
    grounds.reduce_cover(bare);
    TwoSidedPlan plan;
    for (int repairs = 0; repairs <= kMaxRepairs; ++repairs) {
        plan = with_grounds(bare, cells, radius, options.detail, false, executor);
        if (stop.stop_requested() || repairs == kMaxRepairs) break;
        find_white_shares(plan, executor);
        if (!grounds.replace_grounds(bare, plan)) break;
    }
    bare.clear();
    plan.is_nested = false;
    plan.dot_cells = dot_cells_of(cells, radius);
    find_white_shares(plan, executor);
    for (std::vector<float>& channel : picture.light) channel = in_dot_cells(plan, std::move(channel), executor);
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
    const double own_radius = radius / std::sqrt(plan.dot_cell_area());  // in dot cells
    add_mixed_kinds(plan, inks, std::move(picture.light), own_radius, blur_of(plan, options.detail, own_radius), stop,
                    executor);
    if (stop.stop_requested()) return plan;
    set_scale(plan, options, executor);
    return plan;
}

}  // namespace ccdt
