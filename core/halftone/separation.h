#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/halftone/picture.h"
#include "core/halftone/tone.h"

namespace ccdt {

/// A colour in linear light with the primaries of sRGB, in [0, 1].
struct Light {
    float red = 0;
    float green = 0;
    float blue = 0;

    friend bool operator==(const Light&, const Light&) = default;
};

inline constexpr std::size_t kMostInks = 6;

/// Inks and paper that a picture is printed with.
struct InkSet {
    std::vector<Light> inks;  ///< 1 to kMostInks: what a full cover of each looks like, on white or as a lamp on black
    Light paper{1, 1, 1};
    /// false: each ink multiplies what is below it, as print on paper; true: it adds to it, as lamps do
    bool additive = false;
};

/// The mean light where inks cover shares of a place independently of each other.
/// @param cover  [inks] in [0, 1]
Light printed(const InkSet& inks, std::span<const float> cover);

/// The mean light of dots that keep clear of those of other inks where there is room, as distribute_inks() makes them.
/// @param cover  [inks] in [0, 1]: what the dots of each cover
Light halftoned(const InkSet& inks, std::span<const float> cover);

/// Share of each pixel that the dots of each ink shall cover [inks][width * height], in [0, 1], top row first, such
/// that what is halftoned looks as much like the picture as the inks can. One black ink on white paper has the coverage
/// that ink_coverage gives for the picture's luminance.
///
/// Transparent parts show the paper: no dots. Values of the picture beyond [0, 1] count as the nearer end, what is no
/// number as 0. Continuous in the colour. Of the mixtures that look alike that one is taken which covers least, so
/// that with ideal cyan, magenta, yellow and black greys are black alone.
///
/// @param stop  asked once a row; a stop ends it early, with nothing of use
/// O(pixels), and besides that for each kind of colour; all there are take as long as some 300,000 pixels do.
std::vector<std::vector<float>> separate(const ColourPicture& picture, const InkSet& inks, Tone tone,
                                         const std::stop_token& stop = {});

/// Shares sites among inks so that all dots have about one size: in proportion, by largest remainders, but one at least
/// for each ink that covers anything as long as there are enough, those that cover most first. An ink that covers
/// nothing has none; if none covers anything, none has any.
///
/// @param ink_sums  [inks] sum of each ink's coverage; >= 0
/// @returns         [inks], in all `sites`
std::vector<std::size_t> share_sites(std::span<const double> ink_sums, std::size_t sites);

}  // namespace ccdt
