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
    double own_spacing = 1;  ///< as spacing, of the sites of its ink alone; only ratios count
};

/// Pushes sites of different inks apart; those of one ink do not push each other. Of two the one whose ink has fewer
/// sites there goes the further, each in proportion to the area that its ink's sites have: so patterns that are dense,
/// whose gaps are what is seen, stay even.
///
/// @param reach   distance below which they are pushed, over that of neighbours in a hexagonal grid of all inks' sites
/// @param push    share of what is missing by which the two move in the mean
/// @param stop    asked now and then; the rest is not pushed, then
/// @returns       how far each is pushed [sites]
/// Two on the very same place go in different directions. Same input, same bytes. O(sites).
std::vector<Point> push_inks_apart(const Domain& domain, std::span<const InkSite> sites, double reach, double push,
                                   const std::stop_token& stop = {});

}  // namespace ccdt
