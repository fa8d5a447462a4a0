// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/polygon.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {

/// Input bytes with a special meaning. All other bytes encode corners.
enum class PartTag : std::uint8_t { NextPart = 255, NextHole = 254, Nudge = 253, Anywhere = 252 };

/// Takes polygons from an input, corner by corner. A nudge moves the previous corner to a neighbouring double.
/// @param most      maximum number of corners
/// @param far       coordinate beyond all corners; nudges move towards it or away from it
/// @param corner    returns the corner for a byte
/// @param anywhere  takes the coordinates of a corner from the input
template <class Corner, class Anywhere>
std::vector<PolygonPart> take_parts(Bytes& input, std::size_t most, double far, Corner corner, Anywhere anywhere) {
    std::vector<PolygonPart> parts(1);
    for (std::size_t count = 0; !input.empty() && count < most;) {
        const auto byte = input.take<std::uint8_t>();
        Ring& ring = parts.back().holes.empty() ? parts.back().outer : parts.back().holes.back();
        if (byte == static_cast<std::uint8_t>(PartTag::NextPart)) {
            parts.emplace_back();
        } else if (byte == static_cast<std::uint8_t>(PartTag::NextHole)) {
            parts.back().holes.emplace_back();
        } else if (byte == static_cast<std::uint8_t>(PartTag::Nudge)) {
            const double way = input.take<std::int8_t>();
            if (!ring.empty()) ring.back().x = std::nextafter(ring.back().x, std::copysign(far, way));
        } else {
            ring.push_back(byte == static_cast<std::uint8_t>(PartTag::Anywhere) ? anywhere(input) : corner(byte));
            ++count;
        }
    }
    return parts;
}

}  // namespace ccdt::fuzz
