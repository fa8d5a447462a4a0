// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace ccdt {

/// Dots of a kind as they are drawn.
struct SizedDots {
    std::vector<float> radii;         ///< [dots], in cells
    std::vector<std::uint8_t> white;  ///< [dots] channels whose ground is white at the centre, as bits
    std::vector<std::uint8_t> cut;    ///< [dots] channels, of those flipped, whose boundary is near, as bits
};

}  // namespace ccdt
