// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// Clips a ring to a box. The result has edges along the sides where the ring is cut off. By the even-odd rule, the
/// result encloses the same area within the box. Intersections with the sides are rounded.
Ring clipped(Ring ring, const Box& box);

/// Subtracts areas from a domain. Areas may extend beyond the domain by any distance.
///
/// @param domain  not a torus
/// @param areas   in the domain's coordinates
///
/// The unit frame and the bounding box of the domain do not change. Even if an edge of an area ends far outside the
/// domain, its part inside the domain moves by no more than the rounding of the domain's coordinates.
///
/// Errors: Unusable if nothing is left or the areas cross too often; Stopped. Deterministic.
Result<Domain> without(const Domain& domain, std::span<const Area> areas, const std::stop_token& stop = {});

/// Returns a large box minus a domain, in the domain's coordinates. The large box contains the domain and `box`.
/// @param domain  not a torus
Area outside_of(const Domain& domain, const Box& box);

}  // namespace ccdt
