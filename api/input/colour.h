// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "api/input/option_reader.h"
#include "core/base/result.h"

namespace ccdt::api {

/// A colour in sRGB, or transparent.
struct Colour {
    unsigned char red = 0;
    unsigned char green = 0;
    unsigned char blue = 0;
    bool transparent = false;

    friend bool operator==(const Colour&, const Colour&) = default;
};

inline constexpr Colour kBlack = {0, 0, 0};
inline constexpr Colour kWhite = {255, 255, 255};

/// Returns the squared distance between two colours in sRGB, which has 256 values per channel.
int squared_distance(const Colour& a, const Colour& b);

/// Writes a colour as `#rrggbb`; a transparent colour as `#000000`.
std::string hexadecimal(const Colour& colour);

/// Reads `#rgb` or `#rrggbb`. Errors: Malformed.
Result<Colour> read_colour(const Input& input);

/// Reads `min` to `max` different colours: text with commas between them, or a JSON array of strings.
/// Errors: Malformed. For an array, Error::field is a JSON Pointer to the faulty element.
Result<std::vector<Colour>> read_colours(const Input& input, std::size_t min, std::size_t max);

/// Reads `#rgb`, `#rrggbb` or `transparent`. Errors: Malformed.
Result<Colour> read_colour_or_none(const Input& input);

}  // namespace ccdt::api
