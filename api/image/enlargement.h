// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/image/overlay.h"
#include "core/base/executor.h"

namespace ccdt::api {

/// Lightens a picture by half of the light that it loses when it is shown at twice its width and height.
///
/// A screen with two pixels per CSS pixel enlarges pictures. Browsers interpolate encoded values, not light, so the
/// pixels that they insert along the rims of dots are too dark. The loss of a pixel is computed from the 3 x 3 pixels
/// around it, assuming that linear interpolation turns it into four pixels. Only half of the loss is added back,
/// because the same file is also shown at its own size, where no light is lost. Uniform areas do not change.
///
/// Transparent pictures are not changed, because the loss depends on the background behind them.
///
/// The same input gives the same bytes on any executor. O(pixels).
void compensate_enlargement(DotImage& picture, Executor& executor = inline_executor());

}  // namespace ccdt::api
