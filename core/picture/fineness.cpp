// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/fineness.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "core/picture/pixel_ranges.h"
#include "core/picture/srgb.h"
#include "core/picture/tone.h"

namespace ccdt {

namespace {

/// Sums over squares of 2 x 2 pixels.
struct Sums {
    double lightness = 0;
    double squares = 0;           ///< sum of the squared lightness of pixels
    double squares_of_means = 0;  ///< sum of four times the squared mean lightness of squares

    Sums operator+(const Sums& other) const {
        return {lightness + other.lightness, squares + other.squares, squares_of_means + other.squares_of_means};
    }
};

/// Adds the squares of 2 x 2 pixels in two rows.
/// @param first      index of the first pixel of the upper row
/// @param lightness  returns the lightness of a pixel by its index
template <class Lightness>
void add_rows(std::size_t first, std::size_t columns, const Lightness& lightness, Sums& sums) {
    for (std::size_t i = first; i + 1 < first + columns; i += 2) {
        const float a = lightness(i), b = lightness(i + 1), c = lightness(i + columns), d = lightness(i + columns + 1);
        const float all = a + b + c + d;
        sums.lightness += static_cast<double>(all);
        sums.squares += static_cast<double>(a * a + b * b + c * c + d * d);
        sums.squares_of_means += static_cast<double>(all * all / 4);
    }
}

/// Returns the share of the variance of lightness that lies within squares of 2 x 2 pixels.
/// @param lightness  returns the lightness of a pixel by its index
template <class Lightness>
double fineness(int width, int height, Executor& executor, const Lightness& lightness) {
    const auto columns = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
    if (columns < 2 || rows < 2) return 0;
    const std::size_t pairs = rows / 2, range = std::max<std::size_t>(kPixelsOfSum / (2 * columns), 1);
    std::vector<Sums> parts((pairs + range - 1) / range);
    for_ranges(executor, pairs, range, [&](std::size_t begin, std::size_t end) {
        for (std::size_t pair = begin; pair < end; ++pair)
            add_rows(2 * pair * columns, columns, lightness, parts[begin / range]);
    });
    const Sums all = std::accumulate(parts.begin(), parts.end(), Sums());
    constexpr double kFlat = 1e-6;  // a picture with this variance or less counts as flat, because of rounding
    const double count = static_cast<double>(columns / 2 * 2) * static_cast<double>(rows / 2 * 2);
    const double variation = all.squares - all.lightness * all.lightness / count;
    return variation > kFlat * count ? std::clamp((all.squares - all.squares_of_means) / variation, 0.0, 1.0) : 0;
}

/// Returns the lightness of a pixel on white paper.
float seen(float luminance, const Plane& alpha, std::size_t pixel) {
    const float light = std::sqrt(to_share(luminance));
    return alpha.empty() ? light : 1 + (light - 1) * to_share(alpha[pixel]);
}

}  // namespace

double fineness(const Picture& picture, Executor& executor) {
    return fineness(picture.width, picture.height, executor,
                    [&](std::size_t pixel) { return seen(picture.luminance[pixel], picture.alpha, pixel); });
}

double fineness(const ColourPicture& picture, Executor& executor) {
    return fineness(picture.width, picture.height, executor, [&](std::size_t pixel) {
        const float luminance = luminance_of(picture.red[pixel], picture.green[pixel], picture.blue[pixel]);
        return seen(luminance, picture.alpha, pixel);
    });
}

}  // namespace ccdt
