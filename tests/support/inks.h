// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/halftone/separation.h"

namespace ccdt::test {

/// Cyan, magenta, yellow, black, in this order, each of which takes out its part of the light wholly; on white paper.
inline InkSet cmyk_inks() {
    return {{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}, {0, 0, 0}}, {1, 1, 1}, false};
}

/// Red, green and blue light on black.
inline InkSet rgb_inks() {
    return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}, true};
}

}  // namespace ccdt::test
