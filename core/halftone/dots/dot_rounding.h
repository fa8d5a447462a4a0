// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace ccdt {

/// Rounds each coverage to 0 or 255 so that every dot and every hole remains in one piece, and local sums stay nearly
/// the same.
///
/// Within a dot, rounding errors pass from pixels that are nearly covered or nearly bare to those that are less
/// certain. The error of the last pixel of a dot passes to the nearest dots that are rounded later.
///
/// @param shares   [width * height] coverage of each pixel; 255 means fully covered; modified
/// @param covered  [width * height] pixels that are not 0 become 255, unless their coverage is 0; empty: none
/// Pixels of 0 and 255 do not change. Deterministic. O(pixels).
/// Source: order of rounding by classes: Knuth 1987, Digital halftones by dot diffusion. Here, the picture itself has
/// the classes.
void round_dots(std::vector<std::uint8_t>& shares, int width, int height, std::span<const std::uint8_t> covered = {});

}  // namespace ccdt
