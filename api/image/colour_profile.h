// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "api/image/colour_tags.h"
#include "api/image/row_source.h"

namespace ccdt::api {

/// Function that converts a sample, given as a share of the full range, to linear light, 0 to 1.
using ToneCurve = std::function<float(float share)>;

/// Matrix [row][column] that converts linear light to the primaries of sRGB. Rows add up to 1, so white stays white.
using LightMatrix = std::array<std::array<float, 3>, 3>;

/// Steps that convert samples to linear light with the primaries of sRGB: first the transform, then the curves, then
/// the matrix. Each step is optional.
struct ColourConversion {
    enum class Space { Grey, Rgb, Inks, Lab };

    Space space = Space::Rgb;  ///< colour space of the samples
    WordTransform transform;   ///< argument of transform_rows(); none: the samples are used as stored
    /// One curve for grey, or three for red, green and blue. None: the curve of the file format.
    std::vector<ToneCurve> curves;
    std::optional<LightMatrix> matrix;  ///< none: the primaries are those of sRGB
    ToneCurve grey = {};                ///< for pictures without colours; none: the conversion does not apply to them
};

/// Derives the conversion from the colour tags of a file. A profile is used if it is complete, if it describes a
/// scanner, display, printer or colour space, and if its samples are grey, RGB or CMYK. Colours are relative to the
/// white point of the profile. If the profile has conversion tables, they are used with black point compensation.
///
/// High dynamic range (PQ and HLG) is compressed. The largest of red, green and blue, relative to a diffuse white of
/// 203 cd/m2, is x; the three are multiplied by (1 + x / p^2) / (1 + x), where p is 1,000 cd/m2 relative to white.
/// Light above p becomes white. The display of HLG has a peak of 1,000 cd/m2 and a gamma of 1.2.
///
/// @returns  none if there is nothing to convert: there are no usable tags, or the tags describe sRGB, except for
///           rounding
///
/// Sources: ICC.1:2022; Little CMS 2.14; ITU-R BT.2100, BT.2408; Reinhard et al. 2002, equation 4.
std::optional<ColourConversion> convert_colours(const ColourTags& tags);

/// Returns the conversion of CIELAB, as in RowSource::Space::Lab.
std::optional<ColourConversion> convert_lab();

}  // namespace ccdt::api
