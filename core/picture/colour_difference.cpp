// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/colour_difference.h"

#include <cstddef>

#include "core/base/elementary.h"
#include "core/picture/tone.h"

namespace ccdt {

namespace {

/// Weight of differences in chroma and hue, relative to differences in lightness. Lightness matters most to the
/// picture.
constexpr double kColour = 0.5;

}  // namespace

Lab lab_of(const std::array<double, 3>& light) {
    const auto level = [&](std::size_t k) {
        const auto& row = kLightToXyz[k];
        return 100.0 * static_cast<double>(
                           lightness(static_cast<float>(row[0] * light[0] + row[1] * light[1] + row[2] * light[2])));
    };
    const double x = level(0), y = level(1), z = level(2);
    return {y, 500.0 / 116 * (x - y), 200.0 / 116 * (y - z)};
}

ColourDifference::ColourDifference(const Lab& wanted) : wanted_(wanted) {
    const double chroma = elementary::hypot(wanted[1], wanted[2]);
    if (chroma > 0) cosine_ = wanted[1] / chroma, sine_ = wanted[2] / chroma;
    chroma_ = kColour / (1 + 0.045 * chroma);
    hue_ = kColour / (1 + 0.015 * chroma);
}

Lab ColourDifference::operator()(const Lab& seen) const {
    const double a = seen[1] - wanted_[1], b = seen[2] - wanted_[2];
    return {seen[0] - wanted_[0], chroma_ * (cosine_ * a + sine_ * b), hue_ * (cosine_ * b - sine_ * a)};
}

}  // namespace ccdt
