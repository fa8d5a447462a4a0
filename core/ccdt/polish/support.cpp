// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/support.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/density/zones.h"

namespace ccdt {

Support::Support(const Domain& domain, const Density& density, std::optional<double> sites)
    : is_periodic_(domain.is_torus()),
      columns_(density.width()),
      rows_(density.height()),
      sides_(domain.unit_bounds().max),
      to_grid_{columns_ / sides_.x, rows_ / sides_.y} {
    has_density_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (int row = 0; row < rows_; ++row) {
        for (int column = 0; column < columns_; ++column) has_density_.push_back(density.value(column, row) > 0);
    }
    has_gaps_ = std::ranges::find(has_density_, false) != has_density_.end();
    if (!sites || density.is_uniform()) return;
    zone_of_ = find_zones(density, is_periodic_, *sites);
    if (!zone_of_.empty()) zones_ = std::size_t{std::ranges::max(zone_of_)} + 1;
}

Point Support::box_corner(Point p) const {
    if (!is_periodic_) return {};
    return {whole(p.x / sides_.x) * sides_.x, whole(p.y / sides_.y) * sides_.y};
}

/// Returns the column and row of the cell that contains a point or is nearest to it. g is in units of cells.
std::array<int, 2> Support::cell_of(Point g) const {
    return {std::clamp(static_cast<int>(g.x), 0, columns_ - 1), std::clamp(static_cast<int>(g.y), 0, rows_ - 1)};
}

std::uint32_t Support::zone(Point p) const {
    if (zone_of_.empty()) return 0;
    const auto [column, row] = cell_of({p.x * to_grid_.x, p.y * to_grid_.y});
    return zone_of_[number(column, row)];
}

Point Support::nearest_in_zone(Point from, Point to) const {
    const std::uint32_t own = zone(from - box_corner(from));
    const Point corner = box_corner(to), position = to - corner;
    const auto here = inset_in_cell(position, own);
    if (here) return here == position ? to : corner + *here;
    const double reach = std::sqrt(dot(to - from, to - from));
    const auto found = find_nearest(position, reach, own);
    return found && dot(*found - position, *found - position) <= reach * reach ? corner + *found : from;
}

std::optional<Point> Support::inset_in_cell(Point p, std::uint32_t zone) const {
    const Point g{p.x * to_grid_.x, p.y * to_grid_.y};
    const auto [column, row] = cell_of(g);
    if (!is_usable(column, row, zone)) return std::nullopt;
    // For a point on the side of a cell, rounding would decide to which cell it belongs.
    constexpr double kSide = 1e-6;
    const Point q{std::clamp(g.x, column + kSide, column + 1 - kSide), std::clamp(g.y, row + kSide, row + 1 - kSide)};
    return q == g ? p : Point{q.x / to_grid_.x, q.y / to_grid_.y};
}

std::optional<Point> Support::find_nearest(Point p, double reach, std::uint32_t zone) const {
    if (const auto found = inset_in_cell(p, zone)) return found;
    const Point g{p.x * to_grid_.x, p.y * to_grid_.y};
    const auto [column, row] = cell_of(g);
    const double most = reach * std::max(to_grid_.x, to_grid_.y);
    for (int around = 2;; around *= 2) {
        if (const auto found = nearest_within(g, column, row, around, zone))
            return Point{found->x / to_grid_.x, found->y / to_grid_.y};
        if (around > most || around > std::max(columns_, rows_)) return std::nullopt;
    }
}

/// Returns the point nearest to g where the density is not 0, within `around` columns and rows. g and the result are in
/// units of cells.
std::optional<Point> Support::nearest_within(Point g, int column, int row, int around, std::uint32_t zone) const {
    constexpr double kInset = 0.05;  // distance from the sides of a cell, in cells
    double least = std::numeric_limits<double>::infinity();
    std::optional<Point> best;
    for (int j = std::max(0, row - around); j <= std::min(rows_ - 1, row + around); ++j) {
        for (int i = std::max(0, column - around); i <= std::min(columns_ - 1, column + around); ++i) {
            if (!is_usable(i, j, zone)) continue;
            const Point q{std::clamp(g.x, i + kInset, i + 1 - kInset), std::clamp(g.y, j + kInset, j + 1 - kInset)};
            const double distance = dot(q - g, q - g);
            if (distance >= least) continue;
            least = distance;
            best = q;
        }
    }
    return best;
}

}  // namespace ccdt
