// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/base/executor.h"

namespace ccdt {

/// Applies an approximate Gaussian blur to an image, which is mirrored at its sides.
///
/// @param values   [width * height], finite
/// @param sigma    standard deviation in pixels, >= 0; limited to half the image's side along each axis
/// @param scratch  buffer; resized and overwritten
///
/// Applies two extended box filters along each axis, which together have exactly the standard deviation `sigma`.
/// Deterministic for any number of threads. O(pixels) for any sigma.
/// Source: Gwosdek, Grewenig, Bruhn, Weickert 2011, Theoretical foundations of Gaussian convolution by extended box
/// filtering, section 3.
void blur(std::vector<float>& values, int width, int height, double sigma, std::vector<float>& scratch,
          Executor& executor = inline_executor());

/// Does the same with the weights of a Gaussian, cut off at three standard deviations: smoother than blur(), and faster
/// if the standard deviation is a few pixels.
/// @param sigma  not limited
/// O(pixels * sigma).
void blur_directly(std::vector<float>& values, int width, int height, double sigma, std::vector<float>& scratch,
                   Executor& executor = inline_executor());

/// Returns a blurred copy of an image.
std::vector<float> blurred(std::vector<float> values, int width, int height, double sigma,
                           Executor& executor = inline_executor());

}  // namespace ccdt
