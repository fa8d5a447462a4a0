// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/ccdt/plane/distribution.h"
#include "core/ccdt/plane/fixed_area.h"
#include "core/ccdt/polish/support.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Draws the initial sites. Divides the domain's bounding box into cells of equal capacity with up to four sites each,
/// by recursive halving across the longer side. Places each site at random in its cell, with the density as
/// probability. So long waves of density error do not arise, and no grid is visible. If the density is uniform, a cell
/// that the border cuts holds one site. With Start::Random, the box is the only cell.
///
/// If the density has several zones, each zone gets its exact share of the sites: sites follow each other in the order
/// of the cells, at equal steps of the zone's capacity.
///
/// Near the domain's border, only the mean density of a grid cell is known, so a site may be drawn outside the domain.
/// In that case, the caller must draw another position for the site.
class StartSites {
public:
    /// @param domain, density  must outlive this; their documented ranges ensure that numbers of cells fit in an int
    /// @param support          knows the zones of the density; null: there is only one; must outlive this
    StartSites(const Domain& domain, const Density& density, const Options& options, const Support* support = nullptr);

    /// Returns a position for a site, in the unit frame. Sites with close numbers are mostly neighbours. The position
    /// depends on the seed, the site and the attempt alone.
    Point draw(std::size_t site, int attempt) const;

    /// Returns the fixed points of the options, in the unit frame; points far outside are left out.
    const std::vector<Point>& fixed() const { return fixed_; }

    /// Returns the area that the fixed points take. No site is drawn there.
    const FixedArea& fixed_area() const { return fixed_area_; }

private:
    struct Rectangle {
        double x0, x1, y0, y1;  ///< in cells of the grid
    };

    /// The part of a cell that belongs to a zone.
    struct ZoneShare {
        std::uint32_t zone;
        double capacity;
    };

    void make_grid(const Domain& domain, std::size_t sites);
    std::vector<double> masses_remaining(const Domain& domain, const std::vector<double>& share, std::size_t sites);
    void divide(const Rectangle& box, std::size_t sites);
    void share_out_zones();
    template <class Visit>
    void for_parts(const Rectangle& box, Visit&& visit) const;
    double sum(double x, double y) const;
    bool is_cut(const Rectangle& box) const;
    double cut_across_x(const Rectangle& box, double share) const;
    double cut_across_y(const Rectangle& box, double share) const;
    double density_at(double x, double y) const;
    double acceptance(double x, double y) const;
    void number_along_curve();
    Point draw_stream(std::uint64_t stream, int attempt, const Rectangle& box) const;
    Point draw_in_zone(std::size_t site, int attempt) const;
    Point to_unit(double x, double y) const { return {x / columns_ * unit_size_.x, y / rows_ * unit_size_.y}; }

    const Density& density_;
    const Support* support_;  ///< null if there is only one zone
    std::uint64_t seed_;
    Point unit_size_;
    bool knows_cuts_ = false;  ///< whether sums_ holds areas, so that is_cut() can find cells that the border cuts
    int columns_ = 1;
    int rows_ = 1;
    std::vector<Point> fixed_;
    FixedArea fixed_area_;
    std::vector<double> sums_;  ///< capacity left of and below each grid point [rows + 1][columns + 1]
    std::vector<Rectangle> cells_;
    std::vector<std::uint32_t> cell_of_;    ///< [sites] cell in which each site is drawn
    std::vector<ZoneShare> zone_of_;        ///< [sites] zone in which each site is drawn; empty if there is only one
    std::vector<std::uint32_t> stream_of_;  ///< [sites] number of each site's random stream; empty: the site's number
};

}  // namespace ccdt
