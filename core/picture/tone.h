// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/executor.h"
#include "core/picture/picture.h"

namespace ccdt {

/// Quantity of the picture that the dots reproduce.
enum class Tone {
    Linear,      ///< relative luminance, as a densitometer or an eye at a distance averages it
    Perceptual,  ///< CIE L*, which resembles the encoded pixel values; the halftone is lighter
    Density,  ///< relative luminance, matched by the number of dots regardless of their coverage; for point densities
};

/// Returns the CIE 1976 lightness of a relative luminance, both in [0, 1].
float lightness(float luminance);

/// Returns the slope of lightness() at a relative luminance in [0, 1].
float lightness_slope(float luminance);

/// Returns the relative luminance of a lightness; the inverse of lightness().
float luminance(float lightness);

/// Clamps a value to [0, 1]; NaN becomes 0.
float to_share(float value);

/// Returns the share of each pixel that the dots should cover [width * height], in [0, 1], row by row from the top.
///
/// Dark pixels get dots; with `invert`, light ones do. Transparent pixels show the paper, without dots. Values outside
/// [0, 1] are clamped, and NaN counts as 0. Deterministic for any number of threads.
std::vector<float> ink_coverage(const Picture& picture, Tone tone, bool invert, Executor& executor = inline_executor());

/// Returns a number of dots that resolves a picture well.
///
/// The number is one dot per 8 pixels of ink. If the fineness is above 0.02, this number is multiplied by fineness /
/// 0.02, but only up to two dots per pixel of ink. The result is at least 4,096, or one dot per pixel of ink if that is
/// less. It is at most 100,000, at most `limit`, and at least 1. It never decreases with more ink or finer detail.
///
/// @param ink       sum of the shares that dots cover, in pixels of the picture
/// @param fineness  fineness of the picture, in [0, 1]
std::size_t default_sites(double ink, double fineness, std::size_t limit);

/// Radius of dots in a drawing of a million pixels, in pixels: discs, and the largest dots of one field.
inline constexpr double kRadiusOfDiscs = 3, kRadiusOfField = 1.8;

/// Returns a radius of dots for a drawing, in pixels of the drawing. It grows with the fourth root of the number of
/// pixels, so that a larger drawing has both more dots and larger dots. If the detail of the picture is finer than in
/// photographs, the radius is smaller, down to half of this value. The radius is at least 1.
///
/// @param pixels    number of pixels of the drawing, > 0
/// @param fineness  fineness of the picture, in [0, 1]
/// @param usual     radius in a drawing of a million pixels
double radius_of_drawing(double pixels, double fineness, double usual);

/// Returns the number of dots of radius radius_of_drawing() that are needed to cover the ink of a picture. It is at
/// most two per pixel of ink, which suffices for small pictures, at most 100,000, at most `limit`, and at least 1.
///
/// @param ink     sum of the shares that dots cover, in pixels of the picture
/// @param scale   pixels of the drawing per pixel of the picture, > 0
/// @param pixels  number of pixels of the drawing, > 0
std::size_t sites_of_drawing(double ink, double fineness, double scale, double pixels, double usual, std::size_t limit);

/// Maximum of default_scale(), and maximum number of canvas pixels at the default scale.
inline constexpr double kLargestScale = 16;
inline constexpr double kMaxCanvasPixels = 16e6;

/// Returns the default number of canvas pixels per picture pixel along each axis. This is the smallest whole number at
/// which dots that reproduce the picture's mean tone have a radius of at least 3 canvas pixels, and thus look round. If
/// the canvas would have more than kMaxCanvasPixels, the number is smaller, and need not be whole. The result is
/// limited to the range from 0.1 to kLargestScale.
///
/// @param ink     sum of the shares that dots cover, in pixels of the picture
/// @param pixels  number of pixels of the picture
double default_scale(double ink, std::size_t pixels, std::size_t sites);

}  // namespace ccdt
