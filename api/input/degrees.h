#pragma once

#include <optional>
#include <string>

#include "core/geometry/point.h"

namespace ccdt::api {

/// Tells that points which are even in a plane will not be so on the ground, if the plane's x and y are longitude and
/// latitude: of boxes that may be so, and in which the points of one square kilometre are over a tenth more in one
/// place than in another.
/// @returns  a sentence for people; none of other boxes
std::optional<std::string> warning_of_degrees(const Box& bounds);

}  // namespace ccdt::api
