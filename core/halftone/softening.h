// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/halftone/dots.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Softens the rims of dots with a 3 x 3 binomial filter, (1, 2, 1) / 4 along each axis. Beyond the border, the border
/// pixels are repeated. Total coverage stays the same, except for rounding and the border.
///
/// Programs that scale pictures average encoded values instead of light, which darkens the rims of dots. When a picture
/// is enlarged to twice its width and height, soft rims darken by only a third of the amount of hard rims.
///
/// Deterministic for any number of threads. O(pixels).
void soften(Raster& raster, Executor& executor = inline_executor());

}  // namespace ccdt
