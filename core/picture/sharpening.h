// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/base/executor.h"

namespace ccdt {

/// Sharpens an image of coverage such that a blurred copy of the result resembles the original image. Values of 0 and 1
/// do not change, and local sums hardly change.
///
/// @param cover  [width * height] in [0, 1]
/// @param sigma  standard deviation, in pixels, of the blur, as for blurred(); >= 0; 0 returns an identical copy
/// @returns      [width * height] in [0, 1]
/// Takes two steps of deconvolution; further steps would sharpen mostly noise. Deterministic for any number of threads.
/// O(pixels) for any sigma.
/// Source: Richardson 1972, Bayesian-based iterative method of image restoration; Lucy 1974. Departure: the bare share
/// of each pixel is restored like the covered share, and both are scaled to add up to 1. Otherwise black areas would
/// fade along their edges.
std::vector<float> sharpened(const std::vector<float>& cover, int width, int height, double sigma,
                             Executor& executor = inline_executor());

}  // namespace ccdt
