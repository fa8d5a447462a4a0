// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/executor.h"
#include "core/halftone/dots/dots.h"

namespace ccdt {

/// Softens the rims of dots with a 3 x 3 filter: along each axis, a pixel has the weight `own` and each of its
/// neighbours the weight 1. Beyond the border, the border pixels are repeated. Total coverage stays the same, except
/// for rounding and the border.
///
/// Programs that scale pictures average encoded values instead of light, which darkens the rims of dots. When a picture
/// is enlarged to twice its width and height, rims softened with the weight 2 darken by at most a third of the amount
/// of hard rims, and those softened with larger weights by more, but look sharper at the picture's own size.
///
/// Deterministic for any number of threads. O(pixels).
void soften(Raster& raster, unsigned own, Executor& executor = inline_executor());

}  // namespace ccdt
