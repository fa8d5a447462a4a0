// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

namespace ccdt {

/// Ranks the pixels of a tile so that for any rank the pixels below it are spread evenly, and so are the other pixels.
/// The ranks are thresholds for dithering, or a progressive order of points on a grid. The tile repeats without seams.
///
/// Half of the pixels are chosen first: one at random of each horizontal pair, which then moves to neighbouring pixels
/// as long as that lowers the sum of Gaussians between all chosen pixels. Of these, the most crowded pixel is removed
/// repeatedly, by the same Gaussians, and gets the highest rank left. The other half is ranked in the same way from the
/// far end. The last 16th of the pixels, too few for neighbouring Gaussians to overlap, is ranked by
/// progressive_order().
///
/// @param width, height  in pixels, >= 8; their ratio is limited as that of a torus
/// @param stop           polled regularly; a stop is not an error, but the returned ranks must not be used
/// @returns              [width * height] row by row: a permutation of 0 to width * height - 1
///
/// Deterministic. O(n log n).
/// Source: Ulichney 1993, "The void-and-cluster method for dither array generation". Departures: it starts with half of
/// the pixels, not a tenth; few pixels are spread as evenly as many.
std::vector<std::uint32_t> threshold_mask(int width, int height, std::uint64_t seed, const std::stop_token& stop = {});

}  // namespace ccdt
