#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/density/coverage.h"
#include "core/density/density.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Measures how far the density of sites, smoothed over a few of them, is off the wanted one. Sites, and areas by what
/// they want, are spread by cubic B-splines on a grid; each cell shares out what it has too much among the sites that
/// are spread on it, so that nothing of the error is lost. Waves of two cells and shorter, the pattern itself, are
/// smoothed away. Of each row of the grid only points around the area are stored.
class ErrorGrid {
public:
    /// @param sides    of the box that areas and sites lie in, its corner at the origin
    /// @param cell     side of the grid's cells; larger where that were too many of them for so many sites
    /// @param border   of the areas; they want as many sites as there are, together
    /// @param density  stretched over the box
    /// O(rows + cells between borders + density's cells).
    ErrorGrid(Point sides, double cell, std::size_t sites, std::span<const BorderEdge> border, const Density& density);

    /// Spreads sites, which lie in the areas. O(cells + sites).
    void measure(std::span<const Point> sites);

    /// Share of the error, in sites, that falls to one of the sites that were spread: > 0 where they are too many. All
    /// shares add up to 0, but for areas that no site is near.
    double at(Point site) const;

private:
    /// The grid point left of and below the four by four around a place, and how far behind the second one it lies.
    struct Place {
        std::size_t column, row;
        Point fraction;
    };
    Place place(Point p) const {
        const double x = p.x / cell_, y = p.y / cell_;
        const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y);
        return {i, j, {x - static_cast<double>(i), y - static_cast<double>(j)}};
    }
    /// Number of a grid point that is stored.
    std::size_t number(std::size_t column, std::size_t row) const { return numbers_[row] + column; }
    void store(const CrossedCells& pieces, Point side);
    void want(const CrossedCells& masses, Point side);

    double cell_;
    std::size_t columns_, rows_;
    std::vector<std::size_t> numbers_;  ///< [rows] of the first column's point, were it stored; may wrap around
    std::vector<double> wanted_;        ///< [points] sites
    std::vector<double> values_;        ///< [points] sites there are; then the share of them that are too many
};

}  // namespace ccdt
