// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/picture/picture.h"

namespace ccdt {

/// A point of a picture, in shares of its width and height from the upper left corner.
struct Focus {
    double x = 0.5, y = 0.5;

    bool operator==(const Focus&) const = default;
};

/// Returns the rectangle of a picture whose middle is as near to a point as the borders permit. Its left and its upper
/// border are rounded down to whole pixels.
///
/// @param width, height  size of the rectangle in pixels, >= 1 and at most the size of the picture
/// @param focus          the point; coordinates 0 to 1
Picture part_around(const Picture& picture, int width, int height, const Focus& focus);
ColourPicture part_around(const ColourPicture& picture, int width, int height, const Focus& focus);

}  // namespace ccdt
