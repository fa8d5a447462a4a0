// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/halftone/picture.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Tells how fine the detail of a picture is: the share of the variance of its lightness that means over squares of 2 x
/// 2 pixels lose, in [0, 1]. Photographs have 0.01 to 0.06, text and maps of such pixels 0.1 to 0.4, flat pictures 0.
///
/// Lightness is the root of luminance; what is transparent is white. Values of the picture beyond [0, 1] count as the
/// nearer end, what is no number as 0. A last row or column without a partner does not count. Same input, same bytes,
/// whatever the executor. O(pixels).
double fineness(const Picture& picture, Executor& executor = inline_executor());
double fineness(const ColourPicture& picture, Executor& executor = inline_executor());

}  // namespace ccdt
