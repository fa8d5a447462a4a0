// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/fitted_dots.h"

#include <limits>

#include "core/halftone/dot_print.h"

namespace ccdt {

namespace {

/// Returns the standard deviation, in cells, of the blur that averages the error at a dot: the local spacing of dots.
double spread(float ground_per_dot) {
    return std::sqrt(static_cast<double>(ground_per_dot));
}

/// Combines each value with all values within `reach` cells along both axes, by bitwise or. Does not stop at the ends
/// of rows, so values near the left side and near the right side may be combined as well.
void dilate(std::vector<std::uint8_t>& values, const CellGrid& cells, std::size_t reach) {
    const auto columns = static_cast<std::size_t>(cells.columns), rows = static_cast<std::size_t>(cells.rows);
    const auto combine = [&](const std::vector<std::uint8_t>& from, std::size_t count, std::size_t step,
                             std::vector<std::uint8_t>& to) {
        for (std::size_t distance = 1; distance <= std::min(reach, count - 1); ++distance) {
            const std::size_t offset = distance * step;
            for (std::size_t i = offset; i < from.size(); ++i) {
                to[i] |= from[i - offset];
                to[i - offset] |= from[i];
            }
        }
    };
    std::vector<std::uint8_t> from = values;
    combine(from, columns, 1, values);
    from = values;
    combine(from, rows, columns, values);
}

}  // namespace

FittedDots::FittedDots(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, Executor& executor)
    : plan_(plan), executor_(executor), scale_(plan.scale()) {
    for (std::size_t kind = 0; kind < sites.size(); ++kind) {
        if (!sites[kind].empty()) add(plan.kinds[kind], sites[kind]);
    }
    areas_ = planned_;
    changes_.resize(count());
    find_samples();
    find_near_boundary();
}

/// Adds the dots of a kind.
void FittedDots::add(const KindOfDots& kind, std::span<const Point> sites) {
    constexpr double kMinDensity = 1e-4;  // relative to the mean density; limits the area of ground per dot
    const double sum = sum_of_pixels(executor_, kind.density.size(),
                                     [&](std::size_t i) { return static_cast<double>(kind.density[i]); });
    const auto least = std::max(static_cast<float>(kMinDensity * sum / static_cast<double>(kind.density.size())),
                                std::numeric_limits<float>::min());
    const auto unit = static_cast<float>(sum * plan_.dot_cell_area() / static_cast<double>(sites.size()));
    for (const Point& site : sites) {
        sites_.push_back(site);
        flips_.push_back(static_cast<std::uint8_t>(kind.flips));
        planned_.push_back(plan_.at(kind.area, site));
        ground_per_dot_.push_back(unit / std::max(plan_.at(kind.density, site), least));
    }
}

/// Finds the position of each dot in the pyramid of local means.
void FittedDots::find_samples() {
    const double unit = std::sqrt(scale_.x * scale_.y);
    means_ = BlurPyramid(plan_.dot_cells.columns, plan_.dot_cells.rows,
                         unit * spread(*std::ranges::max_element(ground_per_dot_)));
    samples_.resize(count());
    for_pixels(executor_, count(), [&](std::size_t dot) {
        samples_[dot] =
            means_.sample({scale_.x * sites_[dot].x, scale_.y * sites_[dot].y}, unit * spread(ground_per_dot_[dot]));
    });
}

void FittedDots::find_near_boundary() {
    // Half a dot cell to the centre of the dot's cell, one for the interpolation of the level.
    constexpr double kMargin = 1.5;
    const double largest = static_cast<double>(kLargest * *std::ranges::max_element(planned_));
    const double radius = std::max(scale_.x, scale_.y) * std::sqrt(largest / std::numbers::pi);
    const auto reach = static_cast<std::size_t>(radius + kMargin);
    std::vector<std::uint8_t> white(plan_.channels.front().white.size()), black(white.size());
    for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
        const std::vector<float>& share = plan_.channels[c].white;
        for (std::size_t i = 0; i < white.size(); ++i) {
            white[i] |= static_cast<std::uint8_t>((share[i] > 0) << c);
            black[i] |= static_cast<std::uint8_t>((share[i] < 1) << c);
        }
    }
    dilate(white, plan_.dot_cells, reach);
    dilate(black, plan_.dot_cells, reach);
    const auto place = [](double at, int count) {
        return static_cast<std::size_t>(std::clamp(static_cast<int>(at), 0, count - 1));
    };
    for (const Point& site : sites_) {
        const std::size_t column = place(scale_.x * site.x, plan_.dot_cells.columns);
        const std::size_t row = place(scale_.y * site.y, plan_.dot_cells.rows);
        const std::size_t cell = row * static_cast<std::size_t>(plan_.dot_cells.columns) + column;
        near_boundary_.push_back(white[cell] & black[cell]);
    }
}

std::vector<std::array<std::uint32_t, 2>> FittedDots::close_pairs() const {
    return ::ccdt::close_pairs(plan_.cells, sites_, areas_);
}

void FittedDots::add_light(Point place, float amount, std::vector<float>& image) const {
    ::ccdt::add_light(plan_.dot_cells, {scale_.x * place.x, scale_.y * place.y},
                      amount * static_cast<float>(scale_.x * scale_.y), image);
}

void FittedDots::add_disc(Point centre, double radius, float amount, std::vector<float>& image) const {
    constexpr double kSmall = 0.35;  // in dot cells; the extent of smaller discs has no effect
    if (scale_.x * radius < kSmall) return add_light(centre, amount, image);
    const double reach = radius / 2;  // four positions with the same mean and variance as the disc
    for (const double y : {-reach, reach}) {
        for (const double x : {-reach, reach}) add_light(centre + Point{x, y}, amount / 4, image);
    }
}

}  // namespace ccdt
