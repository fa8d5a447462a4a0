#pragma once

#include <span>
#include <stop_token>

#include "core/geometry/domain.h"
#include "core/geometry/polygon.h"
#include "core/result.h"

namespace ccdt {

/// The part of a ring within a box, with edges along its sides where it is cut off: that has the ring's area in the
/// box, by the even-odd rule. Edges end where they cross the sides, rounded.
Ring clipped(Ring ring, const Box& box);

/// What is left of a domain without areas that may reach as far out of it as they like.
///
/// @param domain  no torus
/// @param areas   in the domain's coordinates
/// The unit frame and the bounding box stay what they are. Edges are moved by no more than the rounding of coordinates
/// in the domain, however far out they end.
/// Errors (Unusable): nothing is left; areas that cross too often; Stopped. Same input, same bytes.
Result<Domain> without(const Domain& domain, std::span<const Area> areas, const std::stop_token& stop = {});

/// What of the plane lies outside of a domain, out to beyond a box.
/// @param domain  no torus
Area outside_of(const Domain& domain, const Box& box);

}  // namespace ccdt
