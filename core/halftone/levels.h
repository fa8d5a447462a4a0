// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/halftone/picture.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Levels of a picture, as its editors have them. They act on values as sRGB encodes light: up to `black` these become
/// 0, from `white` on 1, and what lies a share t of the way between the two t^(1 / gamma).
struct Levels {
    double black = 0;  ///< in [0, 1], below white
    double white = 1;  ///< in [0, 1]
    double gamma = 1;  ///< > 0; above 1 what lies between gets lighter

    friend bool operator==(const Levels&, const Levels&) = default;
};

/// Gives a picture levels; with the default ones it stays as it is, to the bit. Alpha stays.
/// Values of the picture beyond [0, 1] count as the nearer end, what is no number as 0.
Picture with_levels(const Picture& picture, const Levels& levels, Executor& executor = inline_executor());

/// Gives levels to red, green and blue alike.
ColourPicture with_levels(const ColourPicture& picture, const Levels& levels, Executor& executor = inline_executor());

}  // namespace ccdt
