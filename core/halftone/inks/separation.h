// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/halftone/inks/overprint.h"
#include "core/picture/picture.h"
#include "core/picture/tone.h"

namespace ccdt {

/// Converts the colours of inks and paper from linear light to the quantity that a tone reproduces.
InkSet toned(const InkSet& inks, Tone tone);

/// A picture separated into inks.
struct Separation {
    /// [inks][width * height] Share of each pixel that the dots of an ink would cover without other inks, in [0, 1].
    std::vector<std::vector<float>> coverage;
    /// Predicted light of the halftone; equal to the light of the picture within the gamut of the inks.
    LightPlanes light;
};

/// Separates a picture into inks. The halftone, as Overprint predicts it, is then as close to the picture as possible.
///
/// Colours within the gamut of the inks are exact. Any other colour becomes the nearest colour of the gamut by
/// ColourDifference, in which lightness counts twice. One black ink on white paper has the coverage that ink_coverage()
/// gives for the picture's luminance. Of several mixtures with the same colour, the one with the least coverage is
/// used. So with ideal cyan, magenta, yellow and black inks, greys consist of black alone. Invisible dots are left out.
///
/// Transparent pixels show the paper, without dots. Values outside [0, 1] are clamped, and NaN counts as 0.
///
/// @param stop  polled once per row; after a stop the result must not be used
/// Deterministic for any number of threads. O(pixels), plus a cost for each different colour. For a picture that
/// contains all colours, this cost equals that of a few million additional pixels.
Separation separate(const ColourPicture& picture, const InkSet& inks, Tone tone, const std::stop_token& stop = {},
                    Executor& executor = inline_executor());

/// Returns the share of light that dots must remove in each channel [red, green, blue][width * height], in [0, 1]. The
/// share is relative to the paper or, for additive inks, to white. Transparent pixels show the paper.
std::vector<std::vector<float>> channel_coverage(const ColourPicture& picture, const InkSet& inks, Tone tone,
                                                 Executor& executor = inline_executor());

/// Divides sites among inks in proportion to their coverage, so that all dots have about the same size.
///
/// Rounds by the method of largest remainders. Each ink with any coverage gets at least one site. If there are too few
/// sites for that, the inks with the most coverage get one site each. An ink without coverage gets none.
///
/// @param ink_sums  [inks] sum of each ink's coverage; >= 0
/// @returns         [inks] numbers whose sum is `sites`, or 0 if no ink has any coverage
std::vector<std::size_t> share_sites(std::span<const double> ink_sums, std::size_t sites);

}  // namespace ccdt
