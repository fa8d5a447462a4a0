// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/halftone/picture.h"

namespace ccdt {

/// Returns the middle of a picture. Where as many columns or rows cannot stay on either side, one more goes on the
/// right or at the bottom.
///
/// @param width, height  of the part, pixels, >= 1 and at most those of the picture
Picture middle_of(const Picture& picture, int width, int height);
ColourPicture middle_of(const ColourPicture& picture, int width, int height);

}  // namespace ccdt
