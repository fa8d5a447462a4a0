// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/executor.h"
#include "core/picture/picture.h"

namespace ccdt {

/// Levels adjustment, as in picture editors. It acts on sRGB values. Values up to `black` become 0, and values from
/// `white` on become 1. In between, black + t (white - black) becomes t^(1 / gamma).
struct Levels {
    double black = 0;  ///< in [0, 1], below white
    double white = 1;  ///< in [0, 1]
    double gamma = 1;  ///< > 0; values above 1 lighten the middle tones

    friend bool operator==(const Levels&, const Levels&) = default;
};

/// Adjusts the levels of a picture. With the default levels, the result is bit for bit the same picture. Alpha does not
/// change. Values outside [0, 1] are clamped, and NaN counts as 0.
Picture with_levels(const Picture& picture, const Levels& levels, Executor& executor = inline_executor());

/// Adjusts the levels of red, green and blue alike.
ColourPicture with_levels(const ColourPicture& picture, const Levels& levels, Executor& executor = inline_executor());

}  // namespace ccdt
