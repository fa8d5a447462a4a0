// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/polygon_moments.h"

#include <algorithm>
#include <cmath>

#include "core/density/grid_walk.h"

namespace ccdt {

namespace {

/// Returns the moments of a polygon of weight 1, relative to a point.
Moments even_moments(std::span<const Point> corners, Point from) {
    Moments moments;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Point a = corners[i] - from, b = corners[(i + 1) % corners.size()] - from;
        const double doubled = cross(a, b);
        moments.mass += doubled / 2;
        moments.first = moments.first + doubled / 6 * (a + b);
    }
    moments.magnitude = moments.mass;
    return moments;
}

}  // namespace

SquaredDensity::SquaredDensity(const Domain& domain, const Density& density) {
    if (density.is_uniform()) return;
    constexpr double kMaxCells = 4194304;
    const double cells = static_cast<double>(density.width()) * density.height();
    const double block = std::max(1.0, std::sqrt(cells / kMaxCells));
    columns_ = std::max(1, static_cast<int>(density.width() / block));
    rows_ = std::max(1, static_cast<int>(density.height() / block));
    to_grid_ = {columns_ / domain.unit_bounds().width(), rows_ / domain.unit_bounds().height()};
    const auto width = static_cast<std::size_t>(columns_);
    std::vector<double> row_masses(width);
    for (int row = 0; row < rows_; ++row) {
        density.resample_row(density.cells(), columns_, rows_, row, row_masses);
        double sum = 0, x_moment = 0;
        sums_.push_back(0);
        x_moments_.push_back(0);
        for (std::size_t i = 0; i < width; ++i) {
            const double value = row_masses[i] / density.largest() * columns_ * rows_ / cells;
            sums_.push_back(sum += value * value);
            x_moments_.push_back(x_moment += value * value * (static_cast<double>(i) + 0.5));
        }
    }
}

Moments SquaredDensity::over(std::span<const Point> corners, Point from) const {
    if (columns_ == 0) return even_moments(corners, from);
    Moments moments;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Point a = corners[i], b = corners[(i + 1) % corners.size()];
        moments.add(along({a.x * to_grid_.x, a.y * to_grid_.y}, {b.x * to_grid_.x, b.y * to_grid_.y}));
    }
    moments.first = {moments.first.x / to_grid_.x - moments.mass * from.x,
                     moments.first.y / to_grid_.y - moments.mass * from.y};
    return moments;
}

/// Returns the contribution of an edge to a polygon's moments, in cells of the grid. Let F(x, y) be the weight on the
/// left of x in the row of y, and G(x, y) the moment of this weight along x. The contributions are the integrals of F,
/// G and y F over dy. Within a cell F is linear and G quadratic, so the values at the midpoint of each piece and a
/// twelfth of the squared extent of the piece suffice.
Moments SquaredDensity::along(Point a, Point b) const {
    Moments moments;
    const double slope = b.y != a.y ? (b.x - a.x) / (b.y - a.y) : 0;
    double y = a.y;
    walk_cells(a, b, columns_, rows_, [&](int column, int row, double x, double dy) {
        const auto cell =
            static_cast<std::size_t>(row) * (static_cast<std::size_t>(columns_) + 1) + static_cast<std::size_t>(column);
        const double weight = sums_[cell + 1] - sums_[cell];
        const double left = sums_[cell] + weight * (x - column);
        const double dx = slope * dy;
        const double squares = x * x + dx * dx / 12 - static_cast<double>(column) * column;
        moments.mass += left * dy;
        moments.magnitude += std::abs(left * dy);
        moments.first.x += (x_moments_[cell] + weight * squares / 2) * dy;
        moments.first.y += ((y + dy / 2) * left + weight * dx * dy / 12) * dy;
        y += dy;
    });
    return moments;
}

}  // namespace ccdt
