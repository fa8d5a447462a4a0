// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "core/geometry/point.h"

namespace ccdt::api {

/// Returns a warning for a bounding box whose coordinates may be longitudes and latitudes: points that are spread
/// evenly in degrees are not spread evenly on the ground.
/// @returns  a sentence for users; none if the coordinates cannot be degrees, or if the number of points per square
///           kilometre varies by less than a tenth
std::optional<std::string> warning_of_degrees(const Box& bounds);

}  // namespace ccdt::api
