// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Finds the nearest place with nonzero density, to keep sites out of regions without density.
class Support {
public:
    /// @param density  if uniform, no member function may be called
    ///
    /// O(density's cells).
    Support(const Domain& domain, const Density& density);

    /// Returns a point with density, at most sqrt(2) times as far from p as the nearest one. Returns p if p has
    /// density, or if no point with density is within reach. O(cells within reach).
    Point nearest(Point p, double reach) const;

    /// Returns p, moved away from the sides of its cell, if the cell has density; else none.
    std::optional<Point> inset_in_cell(Point p) const;

private:
    bool has_density(int column, int row) const {
        return has_density_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                            static_cast<std::size_t>(column)];
    }
    std::optional<Point> nearest_within(Point g, int column, int row, int around) const;

    int columns_;
    int rows_;
    Point to_grid_;
    std::vector<bool> has_density_;  ///< [rows * columns]; stored as bits, which stay in the cache, unlike the density
};

}  // namespace ccdt
