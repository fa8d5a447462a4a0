// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "ccdt/abi.h"
#include "ccdt/control.h"
#include "ccdt/domain.h"
#include "ccdt/sample.h"

namespace ccdt::v2 {

/// A picture in memory. Refers to the memory of the caller.
struct PictureView {
    int width = 0;     ///< pixels, >= 1
    int height = 0;    ///< pixels, >= 1
    int channels = 1;  ///< 1: grey; 2: grey and alpha; 3: red, green and blue; 4: red, green, blue and alpha
    /// [height * width * channels] pixels row by row from the top, with interleaved channels. Bytes are values of sRGB.
    /// Floats are linear light in [0, 1], with the primaries of sRGB; values outside are clamped, and NaN counts as 0.
    /// Alpha goes from 0 (transparent) to 1 or 255, and colours are not premultiplied.
    std::variant<std::span<const std::uint8_t>, std::span<const float>> values;
};

/// Shapes that are drawn at the points of a halftone.
enum class Sides {
    Both,   ///< dots of ink in the light, holes in the ink in the dark, and a net between them
    Ink,    ///< discs of ink on white
    Paper,  ///< white discs on black, which draw the light parts of the picture
};

/// Quantity of the picture that the dots reproduce.
enum class Reproduction {
    Luminance,  ///< relative luminance, as a densitometer or an eye at a distance averages it
    Lightness,  ///< CIE L*; the halftone is lighter
};

/// Way in which partly transparent pixels are mixed with the ground behind them.
enum class Alpha {
    Display,  ///< mixes sRGB values, as viewers and editors do
    Linear,   ///< mixes linear light
};

/// Options of halftone(). The defaults are those of the service for drawings.
struct HalftoneOptions {
    Sides sides = Sides::Both;
    /// Whether dots reproduce red, green and blue. Requires Sides::Both. If not, dots reproduce the luminance.
    bool colour = false;
    Reproduction tone = Reproduction::Luminance;
    double detail = 0.7;                  ///< strength of the sharpening of edges, 0 to 1
    std::uint64_t seed = 0;               ///< 0 to 2^53 - 1
    Quality quality = Quality::Standard;  ///< not Stealthy; with Sides::Both, Draft is the same as Standard
    bool partial = false;          ///< whether a stop while dots move returns the current dots instead of an error
    Alpha alpha = Alpha::Display;  ///< the ground is white or, with Sides::Paper, black
};

/// A halftone: discs, or areas of ink.
struct Halftone {
    int width = 0;     ///< pixels of the picture
    int height = 0;    ///< pixels of the picture
    int channels = 1;  ///< 1: grey; 3: red, green and blue, which the ink of each channel removes
    /// Centres of the discs or, with Sides::Both, sites of the areas. In pixels of the picture; y points down, and the
    /// first pixel covers [0, 1] x [0, 1].
    std::vector<Point> points;
    double radius = 0;  ///< radius of all discs, in pixels of the picture; 0 with Sides::Both
    /// [channels] With Sides::Both, outlines of the ink, in pixels of the picture. They enclose it by the even-odd
    /// rule.
    std::vector<std::vector<Ring>> rings;
    bool stopped = false;  ///< whether a stop ended the computation early; only with HalftoneOptions::partial
};

/// Turns a picture into dots that reproduce its tones when they are drawn.
///
/// @param sites  number of points, 1 to 2^28. The result has exactly this number. The exception is a picture that with
///               Sides::Both consists of black and white areas only: its areas are drawn without points.
///
/// Errors: Malformed for a size, a number of channels or an option out of range, and for a wrong number of values;
/// Unusable if there is nothing to draw, because the picture is all transparent or all white, or with Sides::Paper all
/// black; Stopped. The same arguments give the same dots, whatever the number of threads. O(pixels + sites).
CCDT_EXPORT Halftone halftone(const PictureView& picture, std::size_t sites, const HalftoneOptions& options = {},
                              const Control& control = {});

}  // namespace ccdt::v2
