#pragma once

#include <cstddef>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Spacing of sites around a place, however much denser they are there than elsewhere: by the mean density of the
/// smallest block of cells, of 1, 2 x 2, 4 x 4 and so on, that holds the place and wants a site.
class LocalSpacing {
public:
    /// @param sides    of the box that the density is stretched over
    /// @param density  not uniform; must outlive this
    /// @param sites    in all
    /// O(density's cells).
    LocalSpacing(Point sides, const Density& density, double sites);

    /// 1 / sqrt(density of sites).
    /// @param p  in the box. O(log cells)
    double at(Point p) const;

private:
    struct Level {
        std::size_t columns = 0, rows = 0;
        std::vector<float> sites;  ///< [rows * columns] that each block wants
    };

    double sites_of(std::size_t level, std::size_t column, std::size_t row) const;

    const Density& density_;
    Point cell_;  ///< sides of the density's cells
    double sites_per_value_;
    std::vector<Level> levels_;  ///< blocks of 2 x 2 cells, of 4 x 4 and so on, the last one of all
};

}  // namespace ccdt
