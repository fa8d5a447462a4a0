// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <charconv>
#include <string>

#include "core/geometry/point3.h"

namespace ccdt {

/// Returns a number with the fewest digits that read back to the same double.
inline std::string text(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

/// Returns a point as "(x, y, z)".
inline std::string text(Point3 p) {
    return "(" + text(p.x) + ", " + text(p.y) + ", " + text(p.z) + ")";
}

}  // namespace ccdt
