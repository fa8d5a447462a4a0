#pragma once

#include <array>
#include <cstdint>

#include "api/input/colour.h"

namespace ccdt::api {

/// What pixels look like that dots cover in part: red, green, blue, alpha, by coverage.
///
/// Inks are mixed in linear light, so that from afar pixels look as light as dots of that area; over a transparent
/// background they are the foreground with the coverage as alpha.
using Shades = std::array<std::array<std::uint8_t, 4>, 256>;
Shades shades_of(const Inks& inks);

/// Both are, and none is transparent.
bool are_grey(const Inks& inks);

}  // namespace ccdt::api
