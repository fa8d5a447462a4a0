// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "api/input/colour.h"

namespace ccdt::api {

/// Colour (red, green, blue, alpha) of each pixel value.
using Shades = std::array<std::array<std::uint8_t, 4>, 256>;

/// Returns the colour of a pixel for each coverage of the pixel by an opaque ink, from 0 to 255 (fully covered).
///
/// Ink and paper are mixed in linear light. So from a distance, a pixel looks as light as if a dot covered this share
/// of it. On transparent paper, pixels have the colour of the ink, with the coverage as alpha.
Shades shades_of(const Colour& ink, const Colour& paper);

}  // namespace ccdt::api
