// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/halftone/picture.h"

namespace ccdt {

/// Returns the centred rectangle of a picture. If the number of columns to remove is odd, one more is removed on the
/// right than on the left. If the number of rows is odd, one more is removed at the bottom.
///
/// @param width, height  size of the rectangle in pixels, >= 1 and at most that of the picture
Picture middle_of(const Picture& picture, int width, int height);
ColourPicture middle_of(const ColourPicture& picture, int width, int height);

}  // namespace ccdt
