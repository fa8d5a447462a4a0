// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

namespace ccdt {

/// Ranks the pixels of a tile. For any rank, the pixels with lower ranks are spread evenly, and so are the other
/// pixels. The ranks are thresholds for dithering, or a progressive order of points on a grid. The tile repeats without
/// seams.
///
/// First, half of the pixels are chosen: one at random from each horizontal pair. The chosen pixels move to
/// neighbouring pixels as long as that lowers the sum of Gaussians between all chosen pixels. Then the most crowded
/// chosen pixel, by the same Gaussians, is removed repeatedly and gets the highest rank of the lower half that is still
/// free. The other half of the pixels is ranked likewise, from the highest rank downwards. In each half, the Gaussians
/// of the last pixels, a 16th of the tile, do not overlap; progressive_order() ranks these pixels.
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
