// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <charconv>
#include <string>

#include "core/geometry/point3.h"

namespace ccdt {

/// Returns a point as "(x, y, z)". Coordinates have the fewest digits that read back to the same double.
inline std::string text(Point3 p) {
    const auto shortest = [](double value) {
        char digits[32];
        return std::string(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    };
    return "(" + shortest(p.x) + ", " + shortest(p.y) + ", " + shortest(p.z) + ")";
}

}  // namespace ccdt
