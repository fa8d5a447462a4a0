// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace ccdt {

/// CIE 1976 L*, a*, b*.
using Lab = std::array<double, 3>;

inline double dot(const Lab& a, const Lab& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// CIE XYZ, over that of white, of linear light with the primaries of sRGB.
inline constexpr std::array<std::array<double, 3>, 3> kLightToXyz = {
    {{0.43395, 0.37621, 0.18984}, {0.2126, 0.7152, 0.0722}, {0.01773, 0.10947, 0.87280}}};

/// @param light  linear, red, green, blue with the primaries of sRGB; white is (1, 1, 1)
Lab lab_of(const std::array<double, 3>& light);

/// Differences from a colour, as CIE 1994 has them: those of chroma and hue count the less, the more chroma it has,
/// chroma three times as fast.
class ColourDifference {
public:
    explicit ColourDifference(const Lab& wanted);

    /// Differences in lightness, chroma and hue, whose squares add up.
    Lab operator()(const Lab& seen) const;

private:
    Lab wanted_;
    double cosine_ = 1, sine_ = 0;  ///< of the hue
    double chroma_, hue_;           ///< weights
};

}  // namespace ccdt
