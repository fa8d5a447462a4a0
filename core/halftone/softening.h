// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/halftone/dots.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Softens rims: each pixel becomes the mean of the 3 x 3 pixels around it, weighted by (1, 2, 1) / 4 across and down.
/// Beyond the border pixels are as at it. Total coverage stays but for rounding and the border.
///
/// Programs that scale pictures average encoded values rather than light, and so darken rims. Soft ones lose less: what
/// is enlarged twice, a third of what it would.
///
/// Same input, same bytes, on any executor. O(pixels).
void soften(Raster& raster, Executor& executor = inline_executor());

}  // namespace ccdt
