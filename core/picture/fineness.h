// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/executor.h"
#include "core/picture/picture.h"

namespace ccdt {

/// Measures how fine the detail of a picture is: the share of the variance of lightness that is lost when squares of 2
/// x 2 pixels are averaged, in [0, 1]. Photographs have 0.01 to 0.06, text and maps 0.1 to 0.4, flat pictures 0.
///
/// Lightness is the square root of luminance; transparent pixels are white. Values are clamped to [0, 1]; NaN counts as
/// 0. If a side is odd, the last row or column does not count. Deterministic for any number of threads. O(pixels).
double fineness(const Picture& picture, Executor& executor = inline_executor());
double fineness(const ColourPicture& picture, Executor& executor = inline_executor());

}  // namespace ccdt
