// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "api/input/colour.h"

namespace ccdt::api {

/// Colours of pixels by their value: red, green, blue, alpha.
using Shades = std::array<std::array<std::uint8_t, 4>, 256>;

/// Returns the colours of pixels by the share of them that an opaque ink covers.
///
/// Ink and paper are mixed in linear light, so that from afar pixels look as light as dots of that area. On transparent
/// paper, pixels have the colour of the ink, with the coverage as alpha.
Shades shades_of(const Colour& ink, const Colour& paper);

}  // namespace ccdt::api
