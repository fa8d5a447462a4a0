// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Computes the spacing of sites around a position, even where sites are far denser than in the rest of the box. The
/// spacing follows from the mean density of a block of cells (1, 2 x 2, 4 x 4, ...): the smallest block that contains
/// the position and wants at least one site.
class LocalSpacing {
public:
    /// @param sides    size of the box over which the density is stretched
    /// @param density  not uniform; must outlive this object
    /// @param sites    total number of sites
    ///
    /// O(the density's cells).
    LocalSpacing(Point sides, const Density& density, double sites);

    /// Returns 1 / sqrt(density of sites).
    /// @param p  in the box
    ///
    /// O(log cells).
    double at(Point p) const;

private:
    struct Level {
        std::size_t columns = 0, rows = 0;
        std::vector<float> sites;  ///< [rows * columns] sites wanted by each block
    };

    double sites_of(std::size_t level, std::size_t column, std::size_t row) const;

    const Density& density_;
    Point cell_;  ///< size of the density's cells
    double sites_per_value_;
    std::vector<Level> levels_;  ///< blocks of 2 x 2 cells, 4 x 4 cells and so on, up to a single block
};

}  // namespace ccdt
