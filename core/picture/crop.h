// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/picture/picture.h"

namespace ccdt {

/// Returns the rectangle in the middle of a picture. If an odd number of columns or rows has to be removed, the right
/// or the bottom loses one more.
///
/// @param width, height  size of the rectangle in pixels, >= 1 and at most the size of the picture
Picture middle_of(const Picture& picture, int width, int height);
ColourPicture middle_of(const ColourPicture& picture, int width, int height);

}  // namespace ccdt
