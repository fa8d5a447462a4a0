// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "api/input/colour.h"
#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Appearance of inks that lie on each other and on their paper.
enum class Mixing {
    Cover,     ///< an ink hides what is below it; there is only one
    Multiply,  ///< each ink multiplies the light of what is below it, as print does
    Add,       ///< each ink adds its light, as lamps do
};

struct Ink {
    std::string name;        ///< in answers; empty for the only ink, which answers do not name
    Colour colour = kBlack;  ///< at full coverage, on white paper or as a lamp on black; not transparent
};

/// Inks, their paper, and how they mix.
struct Palette {
    std::vector<Ink> inks = {{}};  ///< 1 to kMostInks of core/halftone/separation.h
    Colour paper = kWhite;         ///< if transparent, the inks are those for white paper
    Mixing mixing = Mixing::Cover;
};

/// Whether inks are those of `cmyk`, in that order, which readers of print files assume.
bool is_cmyk(std::span<const Ink> inks);

/// Reads `gray`, which is one opaque black ink, `cmyk` or `rgb`.
Result<Palette> read_color(const Input& input);

/// Reads 1 to kMostInks different colours: text with commas between them, or a JSON array of strings. The name of each
/// ink is its colour as `\#rrggbb`.
/// Errors: Malformed; for an element of an array, with the element's field.
Result<Palette> read_palette(const Input& input);

}  // namespace ccdt::api
