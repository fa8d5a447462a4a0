// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/enlargement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "api/image/srgb.h"
#include "core/picture/pixel_ranges.h"
#include "core/picture/srgb.h"

namespace ccdt::api {
namespace {

/// Share of the lost light that is added back.
constexpr float kShare = 0.5F;

/// Weights in the linear interpolation that turns a pixel into four: of the pixel itself, of each of two neighbours at
/// its sides, and of one neighbour at a corner. kWeights is the sum of these four weights.
constexpr int kOwn = 9, kSide = 3, kCorner = 1, kWeights = 16;

/// Returns a table of the light of each possible mean of encoded values. The index is the weighted sum of four encoded
/// values, which is kWeights times their mean.
const std::vector<float>& light_of_sums() {
    static const std::vector<float> lights = [] {
        std::vector<float> all(255 * kWeights + 1);
        for (std::size_t sum = 0; sum < all.size(); ++sum)
            all[sum] = light_of_srgb(static_cast<float>(sum) / (255 * kWeights));
        return all;
    }();
    return lights;
}

/// Converts between stored values, encoded (sRGB) values and light.
class Curve {
public:
    /// @param shown  [stored pixel value] the encoded (sRGB) value that it stands for; ascending or descending
    explicit Curve(const std::array<std::uint8_t, 256>& shown) : shown_(shown) {
        for (std::size_t value = 0; value < 256; ++value) light_[value] = static_cast<float>(to_linear(shown[value]));
        const bool ascends = light_[0] <= light_[255];
        const std::size_t last = ascends ? 255 : 0;
        std::size_t value = ascends ? 0 : 255;
        for (std::size_t step = 0; step <= kSteps; ++step) {
            const float wanted = static_cast<float>(step) / kSteps;
            while (value != last) {
                const std::size_t next = ascends ? value + 1 : value - 1;
                if (std::abs(light_[next] - wanted) > std::abs(light_[value] - wanted)) break;
                value = next;
            }
            stored_[step] = static_cast<std::uint8_t>(value);
        }
    }

    int shown(std::uint8_t value) const { return shown_[value]; }
    float light(std::uint8_t value) const { return light_[value]; }

    /// Returns the stored value with the light nearest to `light`.
    std::uint8_t stored(float light) const {
        return stored_[static_cast<std::size_t>(std::clamp(light, 0.0F, 1.0F) * kSteps + 0.5F)];
    }

private:
    static constexpr std::size_t kSteps = 1 << 12;

    std::array<std::uint8_t, 256> shown_;
    std::array<float, 256> light_{};
    std::array<std::uint8_t, kSteps + 1> stored_{};
};

/// Returns the channel that contributes most to the difference in luminance between ink and paper.
std::size_t strongest_channel(const Shades& palette) {
    const auto difference = [&](std::size_t channel) {
        return std::abs(to_linear(palette[255][channel]) - to_linear(palette[0][channel]));
    };
    const std::array shares = {luminance_of(difference(0), 0.0, 0.0), luminance_of(0.0, difference(1), 0.0),
                               luminance_of(0.0, 0.0, difference(2))};
    return static_cast<std::size_t>(std::ranges::max_element(shares) - shares.begin());
}

/// Returns the curve of a palette's strongest channel. Without a palette, returns the curve that red, green and blue
/// share.
Curve curve_of(const DotImage& picture) {
    std::array<std::uint8_t, 256> shown{};
    const std::size_t strongest = picture.colours > 0 ? strongest_channel(picture.palette) : 0;
    for (std::size_t value = 0; value < 256; ++value)
        shown[value] = picture.colours > 0 ? picture.palette[value][strongest] : static_cast<std::uint8_t>(value);
    return Curve(shown);
}

/// The values of a pixel and of its eight neighbours, row by row.
using Neighbourhood = std::array<std::uint8_t, 9>;

/// Returns the mean light that a pixel loses when it is interpolated to four pixels.
float loss(const Curve& curve, const std::vector<float>& lights, const Neighbourhood& around) {
    const std::uint8_t own = around[4];
    float lost = 0;
    for (const auto& at : {std::array<std::size_t, 3>{1, 3, 0}, {1, 5, 2}, {7, 3, 6}, {7, 5, 8}}) {
        const std::uint8_t side = around[at[0]], other = around[at[1]], corner = around[at[2]];
        const auto mean = [&](const auto& value_of) {
            return kOwn * value_of(own) + kSide * (value_of(side) + value_of(other)) + kCorner * value_of(corner);
        };
        const float light = mean([&](std::uint8_t value) { return curve.light(value); }) / kWeights;
        const int encoded = mean([&](std::uint8_t value) { return curve.shown(value); });
        lost += light - lights[static_cast<std::size_t>(encoded)];
    }
    return lost / 4;
}

}  // namespace

void compensate_enlargement(DotImage& picture, Executor& executor) {
    if (picture.transparent) return;
    const Curve curve = curve_of(picture);
    const std::vector<float>& lights = light_of_sums();
    const std::vector<std::uint8_t> before = picture.pixels;
    const std::size_t size = picture.row_size(), step = picture.channels();
    const auto height = static_cast<std::size_t>(picture.height);
    for_rows(executor, picture.width, height, [&](std::size_t y) {
        const std::uint8_t* const row = before.data() + y * size;
        const std::uint8_t* const above = y > 0 ? row - size : row;
        const std::uint8_t* const below = y + 1 < height ? row + size : row;
        for (std::size_t x = 0; x < size; ++x) {
            const std::size_t left = x < step ? x : x - step, right = x + step < size ? x + step : x;
            const Neighbourhood around{above[left], above[x],    above[right], row[left],   row[x],
                                       row[right],  below[left], below[x],     below[right]};
            if (std::ranges::all_of(around, [&](std::uint8_t value) { return value == row[x]; })) continue;
            picture.pixels[y * size + x] = curve.stored(curve.light(row[x]) + kShare * loss(curve, lights, around));
        }
    });
}

}  // namespace ccdt::api
