// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace ccdt {

/// CIE 1976 L*, a*, b*.
using Lab = std::array<double, 3>;

inline Lab operator-(const Lab& a, const Lab& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline double dot(const Lab& a, const Lab& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Matrix that converts linear light with the primaries of sRGB to CIE XYZ relative to white.
inline constexpr std::array<std::array<double, 3>, 3> kLightToXyz = {
    {{0.43395, 0.37621, 0.18984}, {0.2126, 0.7152, 0.0722}, {0.01773, 0.10947, 0.87280}}};

/// Converts linear light to L*, a*, b*.
/// @param light  red, green, blue with the primaries of sRGB; white is (1, 1, 1)
Lab lab_of(const std::array<double, 3>& light);

/// Differences from a wanted colour by the CIE 1994 formula. In this formula, differences of chroma and hue weigh less
/// if the wanted colour has more chroma. Departure: the weights of chroma and hue are halved.
class ColourDifference {
public:
    explicit ColourDifference(const Lab& wanted);

    /// Returns the weighted differences in lightness, chroma and hue. The norm of this vector is the colour difference.
    Lab operator()(const Lab& seen) const;

private:
    Lab wanted_;
    double cosine_ = 1, sine_ = 0;  ///< cosine and sine of the wanted hue angle
    double chroma_, hue_;           ///< weights of the differences
};

}  // namespace ccdt
