// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/local_spacing.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ccdt {

LocalSpacing::LocalSpacing(Point sides, const Density& density, double sites)
    : density_(density),
      cell_{sides.x / density.width(), sides.y / density.height()},
      sites_per_value_(sites / density.total()) {
    auto columns = static_cast<std::size_t>(density.width()), rows = static_cast<std::size_t>(density.height());
    while (columns > 1 || rows > 1) {
        Level level{(columns + 1) / 2, (rows + 1) / 2, {}};
        level.sites.resize(level.columns * level.rows);
        for (std::size_t row = 0; row < rows; ++row) {
            for (std::size_t column = 0; column < columns; ++column) {
                level.sites[row / 2 * level.columns + column / 2] +=
                    static_cast<float>(sites_of(levels_.size(), column, row));
            }
        }
        columns = level.columns;
        rows = level.rows;
        levels_.push_back(std::move(level));
    }
}

/// Returns the number of sites wanted by a block of 2^level x 2^level cells.
double LocalSpacing::sites_of(std::size_t level, std::size_t column, std::size_t row) const {
    if (level == 0) return sites_per_value_ * density_.value(static_cast<int>(column), static_cast<int>(row));
    const Level& blocks = levels_[level - 1];
    return static_cast<double>(blocks.sites[row * blocks.columns + column]);
}

double LocalSpacing::at(Point p) const {
    const auto index = [](double position, int cells) {
        return static_cast<std::size_t>(std::clamp(static_cast<int>(position), 0, cells - 1));
    };
    const std::size_t column = index(p.x / cell_.x, density_.width()), row = index(p.y / cell_.y, density_.height());
    std::size_t level = 0;
    while (level < levels_.size() && sites_of(level, column >> level, row >> level) < 1) ++level;
    // Blocks at the far sides of the grid may be incomplete.
    const auto extent = [level](std::size_t position, int cells) {
        const std::size_t begin = position >> level << level;
        return static_cast<double>(std::min(static_cast<std::size_t>(cells), begin + (std::size_t{1} << level)) -
                                   begin);
    };
    const double area = extent(column, density_.width()) * cell_.x * extent(row, density_.height()) * cell_.y;
    return std::sqrt(area / sites_of(level, column >> level, row >> level));
}

}  // namespace ccdt
