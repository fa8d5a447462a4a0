#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "api/image/colour_tags.h"
#include "api/image/row_source.h"

namespace ccdt::api {

/// Gives linear light, 0 to 1, of a sample that is so large a share of the full range.
using ToneCurve = std::function<float(float share)>;

/// Turns red, green and blue of linear light into those with the primaries of sRGB: [row][column]. Rows add up to 1,
/// so white stays white.
using LightMatrix = std::array<std::array<float, 3>, 3>;

/// Ways by which samples become linear light with the primaries of sRGB: by a transform, should there be one, whose
/// result then is what the rest is for; by curves; by a matrix.
struct ColourConversion {
    enum class Space { Grey, Rgb, Inks };

    Space space = Space::Rgb;           ///< of the samples
    WordTransform transform;            ///< for transform_rows; none: the samples stay as they are
    std::vector<ToneCurve> curves;      ///< of grey, or of red, green, blue; none: as the file's format has it
    std::optional<LightMatrix> matrix;  ///< none: the primaries are those of sRGB
};

/// Reads what a file's tags say. A profile is understood if it is whole, of a scanner, display, printer or colour
/// space, and of grey, RGB or CMYK. Colours are relative to the white of the profile, by its tables with the black
/// point kept.
///
/// @returns  none if there is nothing to be done: there are no tags, none that are understood, or they say that it is
///           sRGB, up to rounding
/// Source: ICC.1:2022; Little CMS 2.14.
std::optional<ColourConversion> convert_colours(const ColourTags& tags);

}  // namespace ccdt::api
