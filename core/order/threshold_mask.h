// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

namespace ccdt {

/// Ranks the pixels of a tile. For any rank, the pixels with lower ranks are spread evenly, and so are the other
/// pixels. The ranks are thresholds for dithering, or a progressive order of grid points. The tile repeats seamlessly.
///
/// First, half of the pixels are chosen: one at random from each horizontal pair. The chosen pixels move to
/// neighbouring pixels as long as that lowers the sum of Gaussians between all chosen pixels. They get the lower half
/// of the ranks, in descending order: each time, the pixel with the largest sum of the other pixels' Gaussians is
/// removed and gets the highest free rank. When only a 16th of the tile is left, the Gaussians no longer overlap, and
/// progressive_order() ranks the remaining pixels. The other pixels get the upper half of the ranks in the same way,
/// but in ascending order.
///
/// @param width, height in pixels, >= 8; their ratio has the same limits as the sides of a torus
/// @param stop           polled regularly; a stop is not an error, but the returned ranks must not be used
/// @returns              [width * height] row by row: a permutation of 0 to width * height - 1
///
/// Deterministic. O(n log n).
/// Source: Ulichney 1993, "The void-and-cluster method for dither array generation". Departures: the start has half of
/// the pixels, not a tenth; sets of few pixels are spread as evenly as sets of many.
std::vector<std::uint32_t> threshold_mask(int width, int height, std::uint64_t seed, const std::stop_token& stop = {});

}  // namespace ccdt
