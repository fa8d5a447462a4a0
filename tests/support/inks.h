// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/halftone/inks/separation.h"

namespace ccdt::test {

/// Returns ideal cyan, magenta, yellow and black, in this order, on white paper. Each absorbs all light of its
/// channels.
inline InkSet cmyk_inks() {
    return {{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}, {0, 0, 0}}, {1, 1, 1}, false};
}

/// Returns red, green and blue light on black.
inline InkSet rgb_inks() {
    return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}, true};
}

}  // namespace ccdt::test
