// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/parallel/executor.h"

namespace ccdt {

/// Blurs a plane of values by about a Gaussian, as if mirrored at its sides.
///
/// @param values   [width * height], finite
/// @param sigma    pixels, >= 0; more than half a side count as that
/// @param scratch  [width * height], overwritten
/// By two extended boxes each way, whose standard deviation is exact. Same input, same bytes, whatever the executor.
/// O(pixels), whatever the sigma.
/// Source: Gwosdek, Grewenig, Bruhn, Weickert 2011, Theoretical foundations of Gaussian convolution by extended box
/// filtering, section 3.
void blur(std::vector<float>& values, int width, int height, double sigma, std::vector<float>& scratch,
          Executor& executor = inline_executor());

/// Blurs a copy.
std::vector<float> blurred(std::vector<float> values, int width, int height, double sigma,
                           Executor& executor = inline_executor());

}  // namespace ccdt
