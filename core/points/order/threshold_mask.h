// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"

namespace ccdt {

/// Ranks the pixels of a tile, or of each frame of an animated tile. For any rank, the pixels of a frame with lower
/// ranks are spread evenly, and so are the other pixels. In an animated tile, the frames in which a pixel has a lower
/// rank are spread evenly in time, too. The ranks are thresholds for dithering, or a progressive order of grid points.
/// The tile repeats seamlessly, also in time.
///
/// The crowding of a pixel is the sum of two-dimensional Gaussians of the chosen pixels of the same frame, and of
/// one-dimensional Gaussians of the same pixel in those frames where it is chosen. First, half of the pixels of each
/// frame are chosen: one at random from each pair of successive pixels. The chosen pixels move to neighbouring pixels
/// as long as that lowers the crowding, for at most 32 sweeps. They get the lower half of the ranks, in descending
/// order: the frames lose their most crowded pixel in turn, and this pixel gets the highest free rank of its frame. As
/// fewer pixels are left, the Gaussians grow. The other pixels get the upper half of the ranks in the same way, but in
/// ascending order.
///
/// @param width, height  in pixels, >= 8
/// @param depth          number of frames, >= 1; there are fewer than 2^32 pixels in all frames together
/// @param stop           polled regularly; a stop is not an error, but the returned ranks must not be used
/// @returns              [depth * height * width] frame by frame and row by row: in each frame, a permutation of 0 to
///                       width * height - 1
///
/// Uses up to two threads for most of the time. Deterministic for any number of threads. O(n log n).
/// Sources: Ulichney 1993, "The void-and-cluster method for dither array generation"; Wolfe, Morrical, Akenine-Moeller,
/// Ramamoorthi 2022, "Spatiotemporal blue noise masks", for the crowding. Departures: the start has half of the pixels,
/// not a tenth; growing Gaussians spread sets of few pixels as evenly as sets of many; all frames have the same ranks.
std::vector<std::uint32_t> threshold_mask(int width, int height, int depth, std::uint64_t seed,
                                          const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt
