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

    /// Returns a point with nonzero density, at most sqrt(2) times as far from p as the nearest such point. Returns p
    /// if the density at p is not 0, or if no such point is within reach. O(cells within reach).
    Point nearest(Point p, double reach) const;

    /// Returns p, moved away from the sides of its cell, if the density of the cell is not 0; else none.
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
