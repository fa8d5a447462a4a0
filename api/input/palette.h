// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "api/input/colour.h"
#include "api/input/option_reader.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Ways in which overlapping inks combine with each other and with the paper.
enum class Mixing {
    Cover,     ///< the ink is opaque, so it hides the paper; only for a single ink
    Multiply,  ///< each ink multiplies the light of the layers below it, as in print
    Add,       ///< each ink adds its light, as lamps do
};

struct Ink {
    std::string name;        ///< name in answers; empty for a single ink, which answers do not name
    Colour colour = kBlack;  ///< colour of solid ink on white paper, or of light on black if inks add; not transparent
};

/// Inks, the paper, and the way in which inks mix.
struct Palette {
    std::vector<Ink> inks = {{}};  ///< 1 to kMaxInks of core/halftone/inks/separation.h
    Colour paper = kWhite;         ///< if transparent, the separation assumes white paper
    Mixing mixing = Mixing::Cover;
};

/// Returns whether inks are cyan, magenta, yellow and black, in this order. Readers of print files assume this order.
bool is_cmyk(std::span<const Ink> inks);

/// Returns whether inks are custom ones that mix, so that a drawing by one field needs sets of inks.
bool has_sets(const Palette& palette);

/// Reads one of the words `gray`, `cmyk` and `rgb`; `gray` is a single opaque black ink.
Result<Palette> read_color(const Input& input);

/// Reads 1 to kMaxInks different colours: text with commas between them, or a JSON array of strings. Each ink is named
/// after its colour, as `\#rrggbb`.
/// Errors: Malformed. For an array, Error::field is a JSON Pointer to the faulty element.
Result<Palette> read_palette(const Input& input);

}  // namespace ccdt::api
