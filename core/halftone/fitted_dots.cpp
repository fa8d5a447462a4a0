// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/fitted_dots.h"

#include <limits>

#include "core/halftone/bilinear.h"
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
    : plan_(plan), executor_(executor) {
    for (std::size_t kind = 0; kind < sites.size(); ++kind) {
        if (!sites[kind].empty()) add(plan.kinds[kind], sites[kind]);
    }
    areas_ = planned_;
    changes_.resize(count());
    choose_grid();
    find_near_boundary();
}

/// Adds the dots of a kind.
void FittedDots::add(const KindOfDots& kind, std::span<const Point> sites) {
    constexpr double kMinDensity = 1e-4;  // relative to the mean density; limits the area of ground per dot
    const double sum = sum_of_pixels(executor_, kind.density.size(),
                                     [&](std::size_t i) { return static_cast<double>(kind.density[i]); });
    const auto least = std::max(static_cast<float>(kMinDensity * sum / static_cast<double>(kind.density.size())),
                                std::numeric_limits<float>::min());
    const auto unit = static_cast<float>(sum / static_cast<double>(sites.size()));
    const auto at = [&](const std::vector<float>& values, Point site) {
        return interpolated(values, plan_.cells.columns, plan_.cells.rows, site);
    };
    for (const Point& site : sites) {
        sites_.push_back(site);
        flips_.push_back(static_cast<std::uint8_t>(kind.flips));
        planned_.push_back(at(kind.area, site));
        ground_per_dot_.push_back(unit / std::max(at(kind.density, site), least));
    }
}

/// Chooses the coarsest grid of error images that resolves the spacing of nearly all dots. With 1.3 cells per spacing
/// instead of 2, the grain of flat greys is six times as large.
void FittedDots::choose_grid() {
    constexpr double kSmallShare = 0.1, kCellsPerSpacing = 2;
    std::vector<float> sorted = ground_per_dot_;
    const auto small = sorted.begin() + static_cast<std::ptrdiff_t>(kSmallShare * static_cast<double>(count()));
    std::ranges::nth_element(sorted, small);
    const double side = std::max(spread(*small) / kCellsPerSpacing, 1.0);
    const auto cells = [&](int count) { return static_cast<int>(std::ceil(count / side)); };
    grid_ = {cells(plan_.cells.columns), cells(plan_.cells.rows)};
    scale_ = {static_cast<double>(grid_.columns) / plan_.cells.columns,
              static_cast<double>(grid_.rows) / plan_.cells.rows};
    const double unit = std::sqrt(scale_.x * scale_.y);
    means_ = BlurPyramid(grid_.columns, grid_.rows, unit * spread(*std::ranges::max_element(ground_per_dot_)));
    samples_.resize(count());
    for_pixels(executor_, count(), [&](std::size_t dot) {
        samples_[dot] =
            means_.sample({scale_.x * sites_[dot].x, scale_.y * sites_[dot].y}, unit * spread(ground_per_dot_[dot]));
    });
}

void FittedDots::find_near_boundary() {
    constexpr double kMargin = 1.5;  // half a cell to the centre of the dot's cell, one cell for the interpolation
    const double largest = static_cast<double>(kLargest * *std::ranges::max_element(planned_));
    const auto reach = static_cast<std::size_t>(std::sqrt(largest / std::numbers::pi) + kMargin);
    std::vector<std::uint8_t> white(plan_.channels.front().light.size()), black(white.size());
    for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
        const Ground& ground = plan_.channels[c].ground;
        for (std::size_t i = 0; i < white.size(); ++i) {
            const bool is_white = ground.level()[i] > 0.5f;
            white[i] |= static_cast<std::uint8_t>(is_white << c);
            black[i] |= static_cast<std::uint8_t>(!is_white << c);
        }
    }
    dilate(white, plan_.cells, reach);
    dilate(black, plan_.cells, reach);
    for (const Point& site : sites_) {
        const auto place = [](double at, int count) { return std::clamp(static_cast<int>(at), 0, count - 1); };
        const auto cell =
            static_cast<std::size_t>(place(site.y, plan_.cells.rows)) * static_cast<std::size_t>(plan_.cells.columns) +
            static_cast<std::size_t>(place(site.x, plan_.cells.columns));
        near_boundary_.push_back(white[cell] & black[cell]);
    }
}

std::vector<std::array<std::uint32_t, 2>> FittedDots::close_pairs() const {
    return ::ccdt::close_pairs(plan_.cells, sites_, areas_);
}

std::vector<float> FittedDots::error_image(const std::vector<float>& values) const {
    if (grid_ == plan_.cells) return values;
    return reduced(values, plan_.cells.columns, plan_.cells.rows, grid_, executor_);
}

void FittedDots::add_light(Point place, float amount, std::vector<float>& image) const {
    ::ccdt::add_light(grid_, {scale_.x * place.x, scale_.y * place.y}, amount * static_cast<float>(scale_.x * scale_.y),
                      image);
}

void FittedDots::add_disc(Point centre, double radius, float amount, std::vector<float>& image) const {
    constexpr double kSmall = 0.35;  // in cells of the grid; the extent of smaller discs has no effect
    if (scale_.x * radius < kSmall) return add_light(centre, amount, image);
    const double reach = radius / 2;  // four positions with the same mean and variance as the disc
    for (const double y : {-reach, reach}) {
        for (const double x : {-reach, reach}) add_light(centre + Point{x, y}, amount / 4, image);
    }
}

}  // namespace ccdt
