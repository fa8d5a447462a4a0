#include "core/halftone/fineness.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/halftone/srgb.h"
#include "core/halftone/tone.h"

namespace ccdt {

namespace {

/// Of all squares of 2 x 2 pixels.
/// @param lightness  of a pixel, by its index
template <class Lightness>
double fineness(int width, int height, const Lightness& lightness) {
    const auto columns = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
    if (columns < 2 || rows < 2) return 0;
    double sum = 0, squares = 0, squares_of_means = 0;
    for (std::size_t y = 0; y + 1 < rows; y += 2) {
        for (std::size_t x = 0; x + 1 < columns; x += 2) {
            const std::size_t i = y * columns + x;
            const float a = lightness(i), b = lightness(i + 1), c = lightness(i + columns),
                        d = lightness(i + columns + 1);
            const float all = a + b + c + d;
            sum += static_cast<double>(all);
            squares += static_cast<double>(a * a + b * b + c * c + d * d);
            squares_of_means += static_cast<double>(all * all / 4);
        }
    }
    constexpr double kFlat = 1e-6;  // what rounding makes of a picture without any detail
    const double count = static_cast<double>(columns / 2 * 2) * static_cast<double>(rows / 2 * 2);
    const double variation = squares - sum * sum / count;
    return variation > kFlat * count ? std::clamp((squares - squares_of_means) / variation, 0.0, 1.0) : 0;
}

/// Lightness of a luminance, on white.
float seen(float luminance, const Plane& alpha, std::size_t pixel) {
    const float light = std::sqrt(to_share(luminance));
    return alpha.empty() ? light : 1 + (light - 1) * to_share(alpha[pixel]);
}

}  // namespace

double fineness(const Picture& picture) {
    return fineness(picture.width, picture.height,
                    [&](std::size_t pixel) { return seen(picture.luminance[pixel], picture.alpha, pixel); });
}

double fineness(const ColourPicture& picture) {
    return fineness(picture.width, picture.height, [&](std::size_t pixel) {
        const float luminance = luminance_of(picture.red[pixel], picture.green[pixel], picture.blue[pixel]);
        return seen(luminance, picture.alpha, pixel);
    });
}

}  // namespace ccdt
