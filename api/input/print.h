#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/input/colour.h"
#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// What a halftone in colour is printed with.
struct Print {
    struct Ink {
        std::string name;
        Colour colour;  ///< of a full cover, on white paper or as a lamp on black
    };

    std::vector<Ink> inks;  ///< 1 to kMostInks of core/halftone/separation.h
    Colour paper = kWhite;  ///< transparent: the inks are those for white
    bool additive = false;  ///< lamps on black; else each ink multiplies what is below it
};

/// Reads `gray`, `cmyk` or `rgb`.
/// @returns  none for gray
Result<std::optional<Print>> read_color(const Input& input);

/// Reads 1 to kMostInks different colours: a text of them with commas between, or a JSON array of strings. Each is
/// named by its colour as #rrggbb.
/// Errors: Malformed, of an array's element with its own field.
Result<Print> read_palette(const Input& input);

}  // namespace ccdt::api
