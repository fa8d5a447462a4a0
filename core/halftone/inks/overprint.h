// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/halftone/inks/coverage_curve.h"

namespace ccdt {

/// A colour in linear light with the primaries of sRGB, in [0, 1].
struct Light {
    float red = 0;
    float green = 0;
    float blue = 0;

    friend bool operator==(const Light&, const Light&) = default;
};

/// Red, green and blue of each pixel of a picture [pixels], in linear light.
using LightPlanes = std::array<std::vector<float>, 3>;

/// Returns the light of a pixel, clamped to [0, 1].
inline Light light_at(const LightPlanes& light, std::size_t pixel) {
    const auto value = [&](std::size_t c) { return std::clamp(light[c][pixel], 0.0f, 1.0f); };
    return {value(0), value(1), value(2)};
}

inline constexpr std::size_t kMaxInks = 6;

/// The inks and the paper of a print.
struct InkSet {
    std::vector<Light> inks;  ///< [1 to kMaxInks] colours of full coverage on white or, if additive, on black
    Light paper{1, 1, 1};
    /// Whether each ink adds light, as lamps do. If not, each ink multiplies the light from below, as in print.
    bool additive = false;
};

/// Returns the mean light of an area that the inks cover independently of each other.
/// @param cover  [inks] in [0, 1]
Light printed(const InkSet& inks, std::span<const float> cover);

/// Predicts the mean light of halftones in several inks whose dots distribute_inks() places.
///
/// Dots of different inks keep apart while there is space. At high coverage they overlap like independent patterns. So
/// the overlap of two inks is the product of their coverages, multiplied by a factor between 0 and 1. The overlap of
/// three or more inks is the product of all their coverages, multiplied by the factors of all pairs of them (Kirkwood's
/// superposition). The colour follows from the shares of all combinations of inks, by Neugebauer's equations. Where
/// inks push each other, the pattern of each ink is less even and covers less.
class Overprint {
public:
    using Numbers = std::array<double, kMaxInks>;
    /// Red, green, blue.
    using Channels = std::array<double, 3>;

    static Channels channels_of(const Light& light) { return {light.red, light.green, light.blue}; }

    explicit Overprint(const InkSet& inks);

    std::size_t count() const { return count_; }

    /// Returns the mean light of a flat tint.
    /// @param cover  [inks] in [0, 1]: coverage that the dots of each ink would have without other inks
    Channels light(const Numbers& cover) const;

private:
    /// [2^count] For each combination of inks, the share of the area that all of its inks cover, whether or not other
    /// inks cover it too. The index of a combination has one bit for each ink.
    using Shares = std::array<double, std::size_t{1} << kMaxInks>;

    Shares shares(const Numbers& cover) const;

    std::size_t count_;
    CoverageCurve curve_;
    /// [2^count] light that each set of inks adds, per share of the area; for the empty set, the light of the paper.
    std::array<Channels, std::size_t{1} << kMaxInks> changes_{};
};

}  // namespace ccdt
