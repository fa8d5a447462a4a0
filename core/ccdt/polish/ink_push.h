// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// A site of one of several inks.
struct InkSite {
    Point position;      ///< in the unit frame; on a torus, any periodic copy
    double spacing = 0;  ///< local spacing of all inks' sites together: 1 / sqrt(density of sites)
    std::uint32_t ink = 0;
    double own_spacing = 1;  ///< local spacing of the sites of the same ink; only ratios matter
};

/// Pushes sites of different inks apart. Sites of the same ink do not push each other. Of two sites, the one of the
/// sparser ink moves farther: the two moves are in proportion to the areas per site of the two inks. So dense patterns,
/// in which gaps would be most visible, stay even.
///
/// @param reach  distance below which sites push each other, relative to the hexagonal distance of the sites of all
///               inks
/// @param push   share of the missing distance by which a site moves, averaged over the two sites
/// @param stop   polled regularly; after a stop the remaining sites are not pushed
/// @returns      the move of each site [sites]
///
/// Coincident sites move in different directions. Deterministic. O(sites).
std::vector<Point> push_inks_apart(const Domain& domain, std::span<const InkSite> sites, double reach, double push,
                                   const std::stop_token& stop = {});

}  // namespace ccdt
