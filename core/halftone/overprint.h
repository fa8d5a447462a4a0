// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/halftone/coverage_curve.h"

namespace ccdt {

/// A colour in linear light with the primaries of sRGB, in [0, 1].
struct Light {
    float red = 0;
    float green = 0;
    float blue = 0;

    friend bool operator==(const Light&, const Light&) = default;
};

/// Red, green and blue of each pixel of a picture, in linear light [pixels].
using LightPlanes = std::array<std::vector<float>, 3>;

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

/// The mean light of halftones of several inks, as distribute_inks() spreads their dots.
///
/// Dots of different inks keep apart where there is room, and where there is none overlap as if they knew nothing of
/// each other. Any two inks overlap by the product of their covers times a factor between 0 and 1; of three and more
/// each pair brings its factor (Kirkwood's superposition). With the shares of all combinations, colours are those of
/// Neugebauer's equations. And where inks push each other, their own dots are spread less evenly, and cover less.
class Overprint {
public:
    using Numbers = std::array<double, kMostInks>;
    /// Red, green, blue.
    using Channels = std::array<double, 3>;

    static Channels channels_of(const Light& light) { return {light.red, light.green, light.blue}; }

    explicit Overprint(const InkSet& inks);

    std::size_t count() const { return count_; }

    /// @param cover  [inks] in [0, 1]: what the dots of each would cover without the others
    Channels light(const Numbers& cover) const;

private:
    /// Share that each combination of inks covers wholly, inks by their bits [2^count].
    using Shares = std::array<double, std::size_t{1} << kMostInks>;

    Shares shares(const Numbers& cover) const;

    std::size_t count_;
    CoverageCurve curve_;
    /// What a share of each combination adds to the light [2^count]; that of none is the paper.
    std::array<Channels, std::size_t{1} << kMostInks> changes_{};
};

}  // namespace ccdt
