// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace ccdt {

/// Sizes of the dots of one kind, and the grounds on which they lie.
struct SizedDots {
    std::vector<float> radii;         ///< [dots] in cells
    std::vector<std::uint8_t> white;  ///< [dots] channels whose ground is white at the dot's centre, as bits
    std::vector<std::uint8_t> cut;    ///< [dots] channels in which the boundary of grounds crosses the dot, as bits
};

}  // namespace ccdt
