#pragma once

#include <span>
#include <string>
#include <vector>

#include "api/input/colour.h"
#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Look of inks where they lie on each other, and on their paper.
enum class Mixing {
    Cover,     ///< an ink hides what is below it; there is but one
    Multiply,  ///< each ink multiplies the light of what is below it, as print does
    Add,       ///< each ink adds its light, as lamps do
};

struct Ink {
    std::string name;        ///< in answers; empty: the only ink, which they do not tell of
    Colour colour = kBlack;  ///< of a full cover, on white paper or as a lamp on black; not transparent
};

/// Inks, the paper that they are put on, and how they mix.
struct Palette {
    std::vector<Ink> inks = {{}};  ///< 1 to kMostInks of core/halftone/separation.h
    Colour paper = kWhite;         ///< transparent: the inks are those for white
    Mixing mixing = Mixing::Cover;
};

/// Whether inks are those of `cmyk`, in their order: what readers of print files take for granted.
bool is_cmyk(std::span<const Ink> inks);

/// Reads `gray`, one opaque black ink, or `cmyk` or `rgb`.
Result<Palette> read_color(const Input& input);

/// Reads 1 to kMostInks different colours: a text of them with commas between, or a JSON array of strings. Each is
/// named by its colour as `\#rrggbb`.
/// Errors: Malformed, of an array's element with its own field.
Result<Palette> read_palette(const Input& input);

}  // namespace ccdt::api
