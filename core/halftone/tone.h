// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "core/halftone/picture.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Scale of lightness that the dots reproduce.
enum class Tone {
    Linear,      ///< relative luminance: what a densitometer or a far eye averages
    Perceptual,  ///< CIE L*: lighter, as the picture's own pixel values read
    Density,     ///< as Linear, but by the number of dots, whatever they cover: for measures of point density
};

/// CIE 1976 lightness of a relative luminance in [0, 1], in [0, 1].
float lightness(float luminance);

/// Inverse of lightness().
float luminance(float lightness);

/// Clamps a value to [0, 1]; what is no number is 0.
float to_share(float value);

/// Share of each pixel that the dots shall cover [width * height], in [0, 1], top row first.
/// Dark pixels want dots; inverted, light ones do. Transparent pixels show the paper: no dots.
/// Values of the picture beyond [0, 1] count as the nearer end, what is no number as 0.
std::vector<float> ink_coverage(const Picture& picture, Tone tone, bool invert, Executor& executor = inline_executor());

/// Dots that resolve a picture well: one for 8 pixels' worth of ink, and where such dots would lose more than 1/50 of
/// what the picture's lightness varies, as many times more as that is more. There are 4,096 at least (as long as that
/// is not more than one a pixel of ink) and 100,000 at most, for detail up to two a pixel of ink; never less than 1 nor
/// more than `limit`. More ink or finer detail never means fewer dots.
///
/// @param ink       sum of the shares that dots cover
/// @param fineness  of the picture, in [0, 1]
std::size_t default_sites(double ink, double fineness, std::size_t limit);

/// Radius of dots that suit a drawing of a size, in its pixels. It is 3 where there are a million pixels, and grows
/// with their fourth root, so that a larger drawing has both more and larger dots. Finer detail than photographs have
/// halves it at most. It is 1 at least.
///
/// @param pixels    of the drawing, > 0
/// @param fineness  of the picture, in [0, 1]
double radius_of_drawing(double pixels, double fineness);

/// Number of such dots that cover the ink of a picture. There are at most two for a pixel of ink, which is all that
/// small pictures show, and 100,000; never less than 1 nor more than `limit`.
///
/// @param ink     sum of the shares that dots cover, in pixels of the picture
/// @param scale   pixels of the drawing per pixel of the picture, > 0
std::size_t sites_of_drawing(double ink, double fineness, double scale, double pixels, std::size_t limit);

/// Limits of default_scale().
inline constexpr double kLargestScale = 16;
inline constexpr double kMostCanvasPixels = 16e6;

/// Canvas pixels per picture pixel, at most 16: the smallest whole number at which dots that keep the mean tone have a
/// radius of 3 pixels or more and so look round; less where the canvas would pass 16 million pixels, but at least 0.1.
double default_scale(const std::vector<float>& coverage, std::size_t sites);

/// Default scale by the sum of the shares and the pixels of the picture.
double default_scale(double ink, std::size_t pixels, std::size_t sites);

}  // namespace ccdt
