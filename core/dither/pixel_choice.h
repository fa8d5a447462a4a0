// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/base/result.h"
#include "core/density/density.h"

namespace ccdt {

/// Computes the share of each pixel: the probability that it belongs to a random set of `count` pixels. The share of an
/// included pixel is 1. Other shares are proportional to the density, except that none exceeds 1.
///
/// @param density   stretched over the raster, its first row over the top row
/// @param included  [width * height] 1 for pixels that are always chosen, 0 for other pixels
/// @param count     >= 1
/// @returns         [width * height] in [0, 1]; 0 where the density is 0 and the pixel is not included; the sum is
///                  `count` except for rounding
///
/// Errors: Unusable if more than `count` pixels are included (field `include`), or if the density is positive in too
/// few pixels (field `sites`). Deterministic for any number of threads. O(pixels) for each of a few passes.
Result<std::vector<double>> pixel_shares(const Density& density, std::span<const std::uint8_t> included, int width,
                                         int height, std::size_t count, Executor& executor = inline_executor());

/// Chooses an exact number of pixels at random, so that they keep apart and their local density follows the shares.
///
/// A first choice gives each rectangle of a hierarchy its own sum of shares, rounded up or down. Each rectangle of the
/// hierarchy is half of the next larger one. Then a search exchanges neighbouring pixels as long as this makes the
/// visible error smaller (search_directly()).
///
/// @param shares  [width * height] in [0, 1], with an integer sum except for rounding
/// @param stop    after a stop, the pixels are spread less evenly
/// @returns       [width * height] 1 for chosen pixels, 0 for other pixels; there are as many ones as the sum of the
///                shares; pixels with the share 1 are always chosen, pixels with the share 0 never
///
/// Deterministic for a seed and any number of threads. O(pixels).
/// Source of the first choice: Deville, Tille 1998, Unequal probability sampling without replacement through a
/// splitting method (pivotal method). Departure: a hierarchy of rectangles determines the pairs of pixels.
std::vector<std::uint8_t> choose_pixels(std::span<const double> shares, int width, int height, std::uint64_t seed,
                                        const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt
