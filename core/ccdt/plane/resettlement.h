// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/ccdt/relax/triangle_goals.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Relocates single sites from areas with too many sites to areas with too few, within the same part of the domain.
/// Small moves cannot correct the number of sites in a narrow tongue: sites would have to pass its neck one by one.
///
/// After a relocation, lists of the mesh's edges and one-rings must be rebuilt.
class Resettlement {
public:
    /// @param mesh          trimmed, not of a torus, with all sites free
    /// @param goals         goals of all triangles, of which only the weights are used; must outlive this
    /// @param least_height  least height of triangles
    ///
    /// O(triangles).
    Resettlement(Triangulation& mesh, const TriangleGoals& goals, double least_height = 0);

    /// Relocates sites that, together with their neighbours, have a surplus of more than half a site. Such a site moves
    /// to a position where more than half a site is missing.
    /// @returns  number of relocated sites
    ///
    /// O(sites), and O(n log n) for the n sites with too many or too few sites around them.
    std::size_t even_out();

    /// Relocates a site to a position beside one of the eight sites with the largest capacities in its part of the
    /// domain. Chooses the first position that is at least `enough` away from all other sites. If there is no such
    /// position, chooses the one that is farthest from all other sites.
    /// @param least  least distance from other sites at the new position
    /// @returns      false, without moving the site, if all positions are closer than `least` to other sites, or if the
    ///               site or the position is near the old or new position of a previously relocated site
    ///
    /// O(sites).
    bool move_away(std::uint32_t site, double least = 0, double enough = 0);

    /// Relocates one of two sites that are too close. The second site may be in another part. In a part with few sites,
    /// the relocated site moves to the position farthest from all other sites, including the sites of other parts. In a
    /// larger part, the site moves as in move_away().
    /// @returns  false, without moving a site, if no position is farther from other sites than the two sites are apart
    ///
    /// O(sites), and O(triangles) for the first call; in a small part, O(triangles of the part * sites nearby).
    bool separate(std::array<std::uint32_t, 2> pair);

private:
    struct Candidate {
        double sites;  ///< surplus or deficit of the site and its neighbours, in sites
        std::uint32_t site;
    };
    /// A candidate position for a site in a small part.
    struct Position {
        double squared = 0;  ///< squared distance to the nearest other site
        std::uint32_t triangle = 0;
        Point point;
    };
    /// Triangles of the parts that have at most 16 sites, and the numbers of sites.
    struct SmallParts {
        std::vector<std::size_t> sites;                     ///< [parts] number of sites, also for large parts
        std::vector<std::vector<std::uint32_t>> triangles;  ///< [parts] empty for large parts
    };

    void share_out();
    void sum_around();
    std::vector<Candidate> candidates(double sign) const;
    std::uint32_t triangle_beside(std::uint32_t site, std::uint32_t other) const;
    double clearance_beside(std::uint32_t to, std::uint32_t site) const;
    bool relocate(std::uint32_t site, std::uint32_t beside);
    void mark_outdated(std::uint32_t site);
    const SmallParts& small_parts();
    bool is_in_small_part(std::uint32_t site);
    Position farthest_position(std::uint32_t site);
    double enough_squared(std::uint32_t site) const;
    std::vector<Point> sites_near(std::span<const std::uint32_t> triangles, std::uint32_t but, double reach) const;
    bool can_be_divided(std::uint32_t triangle, double share) const;

    Triangulation& mesh_;
    const TriangleGoals& goals_;
    double least_height_;
    std::optional<SmallParts> small_parts_;  ///< created when first needed
    std::vector<double> surplus_;            ///< [sites] 1 - the site's own capacity, where 1 is the mean capacity
    std::vector<double> around_;             ///< [sites] sum of the site's own surplus and its neighbours' surpluses
    std::vector<std::uint32_t> largest_triangle_;  ///< [sites] largest triangle of each site
    std::vector<bool> outdated_;                   ///< [sites] whether a relocation has outdated the site's data
};

}  // namespace ccdt
