// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Finds the nearest position with nonzero density, to keep sites out of regions without density, and in their zones of
/// the density (find_zones()).
class Support {
public:
    /// @param density  if uniform, no member function may be called
    /// @param sites    number of sites in the whole grid of the density; none: the whole grid is one zone
    ///
    /// O(density's cells).
    Support(const Domain& domain, const Density& density, std::optional<double> sites = std::nullopt);

    /// Whether the density is zero anywhere.
    bool has_gaps() const { return has_gaps_; }

    std::size_t zones() const { return zones_; }
    /// Returns the zone at a position in the box.
    std::uint32_t zone(Point p) const;

    /// Returns a point with nonzero density, at most sqrt(2) times as far from p as the nearest such point. Returns p
    /// if the density at p is not 0, or if no such point is within reach. O(cells within reach).
    Point nearest(Point p, double reach) const { return find_nearest(p, reach, kAny).value_or(p); }

    /// Returns the position nearest to `to` that has nonzero density and is in the zone of `from`. Returns `from` if
    /// all such positions are farther from `to`. On a torus, both arguments may be outside the box.
    Point nearest_in_zone(Point from, Point to) const;

    /// Returns p, moved away from the sides of its cell, if the density of the cell is not 0; else none.
    std::optional<Point> inset_in_cell(Point p) const { return inset_in_cell(p, kAny); }

    /// Returns the lower left corner of the periodic copy of the box that contains p; without periods, the origin.
    Point box_corner(Point p) const;

private:
    static constexpr std::uint32_t kAny = 0xffffffff;  ///< stands for all zones

    std::size_t number(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
    }
    std::array<int, 2> cell_of(Point g) const;
    bool is_usable(int column, int row, std::uint32_t zone) const {
        const std::size_t cell = number(column, row);
        return has_density_[cell] && (zone == kAny || zone_of_[cell] == zone);
    }
    std::optional<Point> inset_in_cell(Point p, std::uint32_t zone) const;
    std::optional<Point> find_nearest(Point p, double reach, std::uint32_t zone) const;
    std::optional<Point> nearest_within(Point g, int column, int row, int around, std::uint32_t zone) const;

    bool is_periodic_;
    int columns_;
    int rows_;
    Point sides_;
    Point to_grid_;
    bool has_gaps_ = false;
    std::vector<bool> has_density_;  ///< [rows * columns]; stored as bits, which stay in the cache, unlike the density
    std::vector<std::uint32_t> zone_of_;  ///< [rows * columns]; empty if there is one zone
    std::size_t zones_ = 1;
};

}  // namespace ccdt
