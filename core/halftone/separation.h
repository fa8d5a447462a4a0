// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/halftone/overprint.h"
#include "core/halftone/picture.h"
#include "core/halftone/tone.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// What inks on the paper look like by a tone, as inks and paper.
InkSet toned(const InkSet& inks, Tone tone);

/// A picture in inks.
struct Separation {
    /// Share of each pixel that the dots of each ink shall cover by themselves [inks][width * height], in [0, 1].
    std::vector<std::vector<float>> coverage;
    LightPlanes light;  ///< what is seen of that: the picture, where inks can make it
};

/// Separates a picture into inks, such that the halftone looks as much like it as they can (Overprint,
/// ColourDifference): what they can make comes out as it is, of other colours the nearest by CIE 1994, lightness
/// counting twice. One black ink on white paper has the coverage that ink_coverage gives for the picture's luminance.
///
/// Transparent parts show the paper: no dots. Values of the picture beyond [0, 1] count as the nearer end, what is no
/// number as 0. Of the mixtures that look alike that one is taken which covers least, so that with ideal cyan, magenta,
/// yellow and black greys are black alone; dots that would not be seen are left out.
///
/// @param stop  asked once a row; a stop ends it early, with nothing of use
/// Same input, same bytes, whatever the executor. O(pixels), and besides that for each kind of colour; all there are
/// take as long as some million pixels do.
Separation separate(const ColourPicture& picture, const InkSet& inks, Tone tone, const std::stop_token& stop = {},
                    Executor& executor = inline_executor());

/// Share of each channel's light that is to be taken from a picture's pixels [red, green, blue][width * height], in
/// [0, 1]: of that of the paper or, if inks add, of white. Transparent parts show the paper.
std::vector<std::vector<float>> channel_coverage(const ColourPicture& picture, const InkSet& inks, Tone tone,
                                                 Executor& executor = inline_executor());

/// Shares sites among inks so that all dots have about one size: in proportion, by largest remainders, but one at least
/// for each ink that covers anything as long as there are enough, those that cover most first. An ink that covers
/// nothing has none; if none covers anything, none has any.
///
/// @param ink_sums  [inks] sum of each ink's coverage; >= 0
/// @returns         [inks], in all `sites`
std::vector<std::size_t> share_sites(std::span<const double> ink_sums, std::size_t sites);

}  // namespace ccdt
