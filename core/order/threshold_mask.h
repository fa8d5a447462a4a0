#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

namespace ccdt {

/// Ranks the pixels of a tile so that those below any rank, however many, are spread evenly, as are those that are not:
/// thresholds to dither with, or a progressive order of points on a grid. The tile repeats without seams.
///
/// Half of the pixels are found first: from one of each two side by side, drawn at random, on to a neighbouring pixel
/// as long as that lowers the sum of Gaussians between all of them. Of these, the one that the others crowd most goes
/// again and again, by the same Gaussians, and is the last of those left; so do, from the far end, the others. A 16th
/// of all, too few for these Gaussians to reach from one to the next, gets its ranks by progressive_order().
///
/// @param width, height  pixels, >= 8; as far apart as those of a torus may be
/// @param stop           asked now and then; a stop returns ranks that are of no use, and is no error
/// @returns              [width * height] row by row: each of 0 to width * height - 1 once
/// Same input, same bytes. O(n log n).
/// Source: Ulichney 1993, "The void-and-cluster method for dither array generation". Departures: it starts with half of
/// the pixels rather than a tenth, and few pixels are as even as many.
std::vector<std::uint32_t> threshold_mask(int width, int height, std::uint64_t seed, const std::stop_token& stop = {});

}  // namespace ccdt
