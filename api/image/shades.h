#pragma once

#include <array>
#include <cstdint>

#include "api/input/colour.h"

namespace ccdt::api {

/// Colours of pixels by their value: red, green, blue, alpha.
using Shades = std::array<std::array<std::uint8_t, 4>, 256>;

/// Mixes the shades of pixels that an opaque ink covers in part, by its coverage.
///
/// Ink and paper are mixed in linear light, so that from afar pixels look as light as dots of that area; over a
/// transparent paper they are the ink with the coverage as alpha.
Shades shades_of(const Colour& ink, const Colour& paper);

}  // namespace ccdt::api
