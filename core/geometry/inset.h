#pragma once

#include <functional>
#include <stop_token>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/result.h"

namespace ccdt {

struct Disc {
    Point centre;
    double radius = 0;
};

/// What of a domain is at least so far from its border.
///
/// @param domain    no torus
/// @param distance  > 0, in the domain's coordinates
/// The unit frame and the bounding box stay what they are. The new border is nowhere nearer than it should be, and
/// farther by 1 part in 100 at most: arcs around corners are polygons about circles, and coasts that are much finer
/// than the distance are taken for coarser ones. Errors (Unusable): nothing is left; Stopped. Same input, same bytes.
/// O(n log n) for all inputs that people draw, however ragged.
///
/// Why not GEOS' buffer of a negative distance: its arcs cut corners, and it drops what of the border is finer than a
/// hundredth of the distance, either of which leaves points too near.
Result<Domain> inset(const Domain& domain, double distance, const std::stop_token& stop = {});

/// What is too near to a point of the border, in the domain's coordinates; of radius 0 if nothing is. It changes
/// smoothly along the border.
using DiscAround = std::function<Disc(Point)>;

/// Erodes a domain by discs around the points of its border; otherwise as above.
/// @param indifference  distance in the domain's coordinates by which the new border may be farther besides. Of many
///                      corners discs that differ by less count as equally large, which is far less work
Result<Domain> inset(const Domain& domain, const DiscAround& disc_around, double indifference = 0,
                     const std::stop_token& stop = {});

/// The largest distance that a point of a domain has from its border, in the domain's coordinates: one that there is
/// indeed, and at most 1 part in 100 less than the largest.
/// @param stop  asked now and then: what was found so far, then
/// O(n) for each of some hundred places. Source: Garcia-Castellanos, Lombardo, Poles of inaccessibility, Scottish
/// Geographical Journal 123 (2007); Agafonkin, Polylabel (2016).
double largest_clearance(const Domain& domain, const std::stop_token& stop = {});

}  // namespace ccdt
