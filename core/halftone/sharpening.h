// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/parallel/executor.h"

namespace ccdt {

/// Sharpens what is to be covered, so that it looks more as it did once it is blurred. What is 0 or 1 stays so, and
/// sums around any place stay nearly.
///
/// @param cover  [width * height] in [0, 1], as is what is returned
/// @param sigma  pixels, >= 0: of the blur, as blurred() has it; by 0 nothing changes, to the bit
/// Two steps of deconvolution: what more of them sharpen is mostly noise. Same input, same bytes, whatever the
/// executor. O(pixels), whatever the sigma. Source: Richardson 1972, Bayesian-based iterative method of image
/// restoration; Lucy 1974. Departure: what is bare is restored beside what is covered, and the two keep adding up to 1;
/// else black would fade along its edges.
std::vector<float> sharpened(const std::vector<float>& cover, int width, int height, double sigma,
                             Executor& executor = inline_executor());

}  // namespace ccdt
