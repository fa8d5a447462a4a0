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
    Point place;         ///< in the unit frame; on a torus anywhere
    double spacing = 0;  ///< of the sites of all inks together around it: 1 / sqrt(density of sites)
    std::uint32_t ink = 0;
};

/// Pushes sites of different inks apart; those of one ink do not push each other.
///
/// @param reach   distance below which they are pushed, over that of neighbours in a hexagonal grid of all inks' sites
/// @param push    share of what is missing by which each of the two moves
/// @param stop    asked now and then; the rest is not pushed, then
/// @returns       how far each is pushed [sites]
/// Two on the very same place go in different directions. Same input, same bytes. O(sites).
std::vector<Point> push_inks_apart(const Domain& domain, std::span<const InkSite> sites, double reach, double push,
                                   const std::stop_token& stop = {});

}  // namespace ccdt
