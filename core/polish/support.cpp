// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/polish/support.h"

#include <algorithm>
#include <limits>

namespace ccdt {

Support::Support(const Domain& domain, const Density& density) : columns_(density.width()), rows_(density.height()) {
    const Point sides = domain.unit_bounds().max;
    to_grid_ = {columns_ / sides.x, rows_ / sides.y};
    has_density_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (int row = 0; row < rows_; ++row) {
        for (int column = 0; column < columns_; ++column) has_density_.push_back(density.value(column, row) > 0);
    }
}

std::optional<Point> Support::inset_in_cell(Point p) const {
    const Point g{p.x * to_grid_.x, p.y * to_grid_.y};
    const int column = std::clamp(static_cast<int>(g.x), 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(g.y), 0, rows_ - 1);
    if (!has_density(column, row)) return std::nullopt;
    // For a point on the side of a cell, rounding would decide to which cell it belongs.
    constexpr double kSide = 1e-6;
    const Point q{std::clamp(g.x, column + kSide, column + 1 - kSide), std::clamp(g.y, row + kSide, row + 1 - kSide)};
    return q == g ? p : Point{q.x / to_grid_.x, q.y / to_grid_.y};
}

Point Support::nearest(Point p, double reach) const {
    if (const auto found = inset_in_cell(p)) return *found;
    const Point g{p.x * to_grid_.x, p.y * to_grid_.y};
    const int column = std::clamp(static_cast<int>(g.x), 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(g.y), 0, rows_ - 1);
    const double most = reach * std::max(to_grid_.x, to_grid_.y);
    for (int around = 2;; around *= 2) {
        if (const auto found = nearest_within(g, column, row, around))
            return {found->x / to_grid_.x, found->y / to_grid_.y};
        if (around > most || around > std::max(columns_, rows_)) return p;
    }
}

/// Returns the point nearest to g where the density is not 0, within `around` columns and rows. g and the result are in
/// units of cells.
std::optional<Point> Support::nearest_within(Point g, int column, int row, int around) const {
    constexpr double kInset = 0.05;  // distance from the sides of a cell, in cells
    double least = std::numeric_limits<double>::infinity();
    std::optional<Point> best;
    for (int j = std::max(0, row - around); j <= std::min(rows_ - 1, row + around); ++j) {
        for (int i = std::max(0, column - around); i <= std::min(columns_ - 1, column + around); ++i) {
            if (!has_density(i, j)) continue;
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
