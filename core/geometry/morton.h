// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/geometry/point.h"
#include "core/geometry/point3.h"

// Positions along Morton's space-filling curve. Nearby points mostly have close positions on the curve.
namespace ccdt {

/// Returns the position of a point of the unit square, with 31 bits per coordinate.
inline std::uint64_t morton_position(Point p) {
    const auto spread = [](double v) {
        auto bits = static_cast<std::uint64_t>(std::clamp(v * 0x1p31, 0.0, 0x1p31 - 1));
        bits = (bits | bits << 16) & 0x0000ffff0000ffff;
        bits = (bits | bits << 8) & 0x00ff00ff00ff00ff;
        bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0f;
        bits = (bits | bits << 2) & 0x3333333333333333;
        return (bits | bits << 1) & 0x5555555555555555;
    };
    return spread(p.x) | spread(p.y) << 1;
}

/// Returns the position of a point of the unit cube, with 21 bits per coordinate.
inline std::uint64_t morton_position(Point3 p) {
    const auto spread = [](double v) {
        auto bits = static_cast<std::uint64_t>(std::clamp(v * 0x1p21, 0.0, 0x1p21 - 1));
        bits = (bits | bits << 32) & 0x001f00000000ffff;
        bits = (bits | bits << 16) & 0x001f0000ff0000ff;
        bits = (bits | bits << 8) & 0x100f00f00f00f00f;
        bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
        return (bits | bits << 2) & 0x1249249249249249;
    };
    return spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2;
}

}  // namespace ccdt
