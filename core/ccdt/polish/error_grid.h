// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/density/coverage.h"
#include "core/density/density.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Measures the smoothed difference between the actual and the wanted density of sites. Cubic B-splines spread each
/// site over the points of a grid. The areas where sites are wanted are spread in the same way, weighted by the number
/// of sites that they want. Each grid point distributes its excess over the sites that were spread on it, so no error
/// is lost. Waves of two cells and shorter belong to the pattern of the sites itself; they are smoothed away. In each
/// row, only grid points near the areas are stored.
class ErrorGrid {
public:
    /// @param sides    size of the box that contains areas and sites; the box's lower left corner is the origin
    /// @param cell     side of the grid's cells; enlarged if the box would have more than 64 points per site
    /// @param border   border of the areas, which together want `sites` sites
    /// @param density  wanted density of sites, stretched over the box
    ///
    /// O(rows + cells between borders + the density's cells).
    ErrorGrid(Point sides, double cell, std::size_t sites, std::span<const BorderEdge> border, const Density& density);

    /// Measures the error of sites, all of which lie in the areas. O(cells + sites).
    void measure(std::span<const Point> sites);

    /// Returns the share of the error that is assigned to `site`, as a number of sites. `site` must be a measured site.
    /// The share is > 0 where there are too many sites. All shares add up to 0, unless an area has no site nearby.
    double at(Point site) const;

private:
    /// The 4 x 4 grid points around a position. `column` and `row` are those of the lower left point. `fraction` is the
    /// offset of the position, in cells, from the point in the second row and column.
    struct Position {
        std::size_t column, row;
        Point fraction;
    };
    Position position(Point p) const {
        const double x = p.x / cell_, y = p.y / cell_;
        const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y);
        return {i, j, {x - static_cast<double>(i), y - static_cast<double>(j)}};
    }
    /// Returns the index of a stored grid point.
    std::size_t number(std::size_t column, std::size_t row) const { return numbers_[row] + column; }
    void choose_stored(const CrossedCells& pieces, Point side);
    void spread_wanted(const CrossedCells& masses, Point side);

    double cell_;
    std::size_t columns_, rows_;
    /// [rows] index in wanted_ and values_ that the point in column 0 would have if it were stored; may wrap around.
    std::vector<std::size_t> numbers_;
    std::vector<double> wanted_;  ///< [points] number of wanted sites
    /// [points] first the number n of actual sites, then, after measure(), the error (n - number of wanted sites) / n.
    std::vector<double> values_;
};

}  // namespace ccdt
