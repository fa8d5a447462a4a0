// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include "core/geometry/point3.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// Returns the mean of the centroids of polygons, weighted by area. Holes are ignored, and rings are closed.
///
/// @param on_globe  whether coordinates are longitudes and latitudes in degrees; the result is then near the unit
///                  sphere, with no seam at 180 degrees. Otherwise its z is 0.
/// @returns         none if the polygons have no area, or if their coordinates are too large for a domain
std::optional<Point3> middle_of(std::span<const PolygonPart> parts, bool on_globe);

}  // namespace ccdt
