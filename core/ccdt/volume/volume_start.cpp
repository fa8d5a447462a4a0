// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/volume_start.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/random.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/solid_domain.h"

namespace ccdt {

namespace {

/// Draws sites in cells, so that each zone and each class of zones gets its number of sites. For this purpose, keeps
/// account of the sites that each zone and each class should have had so far, minus the sites drawn there.
template <class Domain>
class SiteDraw {
public:
    SiteDraw(const Domain& domain, const VoxelDensity& density, const VoxelDensity& inside, const VoxelZones& zones,
             std::uint64_t seed)
        : domain_(domain),
          density_(density),
          inside_(inside),
          zones_(zones),
          seed_(seed),
          in_zone_(zones.count()),
          in_class_(zones.classes()) {}

    /// Returns a position for a site, which is outside the domain or the density if none is found.
    /// @param box  relative to the sides of the domain
    Point3 operator()(Box3 box, std::size_t site) {
        Random random(seed_, site);
        found_.clear();
        met_gap_ = false;
        Point3 position = search(box, random);
        // A cell of `inside_` may contain a gap of the density, and the whole box may lie in this gap.
        while (found_.empty() && met_gap_ && widen(box)) position = search(box, random);
        if (found_.empty() || zones_.count() == 1) return position;
        double all = 0;
        for (const Found& each : found_) all += each.weight;
        for (const Found& each : found_) {
            in_zone_[each.zone] += each.weight / all;
            in_class_[zones_.class_of(each.zone)] += each.weight / all;
        }
        const auto missing = [this](const Found& each) {
            return std::pair(in_class_[zones_.class_of(each.zone)], in_zone_[each.zone]);
        };
        const Found& chosen = *std::ranges::max_element(found_, {}, missing);
        --in_zone_[chosen.zone];
        --in_class_[zones_.class_of(chosen.zone)];
        return chosen.first;
    }

private:
    /// Doubles the sides of a box, as far as the domain's bounding box allows.
    /// @returns  whether the box has grown
    static bool widen(Box3& box) {
        bool has_grown = false;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            double &low = along(box.min, axis), &high = along(box.max, axis);
            const double margin = (high - low) / 2;
            has_grown |= low > 0 || high < 1;
            low = std::max(low - margin, 0.0);
            high = std::min(high + margin, 1.0);
        }
        return has_grown;
    }

    /// Draws positions in a box, and collects those in the domain where the density is positive. If there is only one
    /// zone, one such position is enough.
    /// @returns  the last position
    Point3 search(const Box3& box, Random& random) {
        constexpr int kAttempts = 32;  // a site of a thin part of a solid is hard to find at random
        const Point3 sides = domain_.sides;
        Point3 position;
        for (int attempt = 0; attempt < kAttempts && (found_.empty() || zones_.count() > 1); ++attempt) {
            const double x = random.uniform(), y = random.uniform(), z = random.uniform();
            const Point3 p = inside_.draw(box, {x, y, z});
            position = {p.x * sides.x, p.y * sides.y, p.z * sides.z};
            if (!domain_.contains(position)) continue;
            if (density_.is_positive(p)) {
                add(zones_.at(p), weight_at(p), position);
            } else {
                met_gap_ = true;
            }
        }
        return position;
    }

    void add(std::uint32_t zone, double weight, Point3 position) {
        const auto known = std::ranges::find(found_, zone, &Found::zone);
        if (known == found_.end()) {
            found_.push_back({zone, weight, position});
        } else {
            known->weight += weight;
        }
    }

    /// Returns the density at a position, relative to the density with which the position was drawn. They differ in a
    /// solid, because a cell of `inside_` may contain parts of several voxels.
    double weight_at(Point3 p) const {
        constexpr double kMin = 1e-9;  // makes sums of weights positive
        const double drawn = inside_.at(p);
        return drawn > 0 ? std::max(density_.at(p) / drawn, kMin) : 1;
    }

    /// The positions found in a zone.
    struct Found {
        std::uint32_t zone;
        double weight;
        Point3 first;
    };

    const Domain& domain_;
    const VoxelDensity& density_;
    const VoxelDensity& inside_;
    const VoxelZones& zones_;
    std::uint64_t seed_;
    std::vector<double> in_zone_;   ///< [zones] sites that the zone should have had so far, minus those that it has
    std::vector<double> in_class_;  ///< [classes] the same for the zones of a class
    std::vector<Found> found_;      ///< in the current cell
    bool met_gap_ = false;          ///< whether a position in the domain had no density
};

}  // namespace

template <class Domain>
std::vector<Point3> draw_start(const Domain& domain, const VoxelDensity& density, const VoxelDensity& inside,
                               const VoxelZones& zones, std::size_t sites, std::span<const Point3> fixed,
                               std::uint64_t seed, const std::stop_token& stop) {
    constexpr std::size_t kMaxPerCell = 4;
    struct Cell {
        Box3 box;  ///< relative to the domain's sides
        std::size_t sites;
        std::span<Point3> fixed;
    };
    const Point3 sides = domain.sides;
    std::vector<Point3> sorted(fixed.begin(), fixed.end());
    std::vector<Cell> cells{{{{0, 0, 0}, {1, 1, 1}}, sites, sorted}};
    std::vector<Point3> drawn;
    drawn.reserve(sites + fixed.size());
    SiteDraw draw(domain, density, inside, zones, seed);
    while (!cells.empty() && !stop.stop_requested()) {
        const Cell cell = cells.back();
        cells.pop_back();
        const std::size_t points = cell.sites + cell.fixed.size();
        if (points <= kMaxPerCell || cell.sites == 0) {
            for (std::size_t i = 0; i < cell.sites; ++i) {
                const Point3 position = draw(cell.box, drawn.size());
                drawn.push_back(domain.moved(drawn.empty() ? domain.interior() : drawn.back(), position));
            }
            continue;
        }
        const Point3 size = cell.box.max - cell.box.min;
        const std::array lengths{size.x * sides.x, size.y * sides.y, size.z * sides.z};
        const std::size_t axis = lengths[0] >= lengths[1] && lengths[0] >= lengths[2] ? 0
                                 : lengths[1] >= lengths[2]                           ? 1
                                                                                      : 2;
        Cell low = cell, high = cell;
        const std::size_t low_points = points / 2;
        const double share = static_cast<double>(low_points) / static_cast<double>(points);
        const double plane = inside.cut(cell.box, axis, share);
        along(low.box.max, axis) = along(high.box.min, axis) = plane;
        const auto is_low = [&](Point3 p) { return along(p, axis) < plane * along(sides, axis); };
        const auto middle = std::partition(cell.fixed.begin(), cell.fixed.end(), is_low);
        low.fixed = {cell.fixed.begin(), middle};
        high.fixed = {middle, cell.fixed.end()};
        // If the fixed points alone are too many for one part, the other one gets all sites.
        low.sites = std::min(cell.sites, low_points - std::min(low_points, low.fixed.size()));
        high.sites = cell.sites - low.sites;
        cells.push_back(high);
        cells.push_back(low);
    }
    drawn.insert(drawn.end(), fixed.begin(), fixed.end());
    return drawn;
}

template std::vector<Point3> draw_start(const BoxDomain3&, const VoxelDensity&, const VoxelDensity&, const VoxelZones&,
                                        std::size_t, std::span<const Point3>, std::uint64_t, const std::stop_token&);
template std::vector<Point3> draw_start(const SolidDomain&, const VoxelDensity&, const VoxelDensity&, const VoxelZones&,
                                        std::size_t, std::span<const Point3>, std::uint64_t, const std::stop_token&);

}  // namespace ccdt
