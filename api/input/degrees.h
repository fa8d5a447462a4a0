// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "core/geometry/point.h"

namespace ccdt::api {

/// Warns that points spread evenly in a plane are not spread evenly on the ground, if x and y are longitude and
/// latitude. The warning is for boxes that may be in degrees, and in which the number of points per square kilometre
/// varies by more than a tenth.
/// @returns  a sentence for people; none for other boxes
std::optional<std::string> warning_of_degrees(const Box& bounds);

}  // namespace ccdt::api
