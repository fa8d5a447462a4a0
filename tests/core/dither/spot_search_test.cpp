// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/spot_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/base/thread_executor.h"
#include "core/dither/error_diffusion.h"
#include "core/picture/blur.h"

namespace ccdt {
namespace {

using Dark = std::vector<std::uint8_t>;

std::size_t area(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

std::size_t pixel(int width, int x, int y) {
    return area(width, y) + static_cast<std::size_t>(x);
}

/// Returns the covered share of each square: the share of samples in it that are within half a diameter of a dark
/// pixel.
std::vector<float> printed(const Dark& dark, int width, int height, double diameter) {
    constexpr int kSamples = 32;
    std::vector<float> covered(dark.size(), 0.0f);
    for (int sample = 0; sample < kSamples * kSamples; ++sample) {
        const double right = (sample % kSamples + 0.5) / kSamples - 0.5;
        const double down = (sample / kSamples + 0.5) / kSamples - 0.5;
        std::vector<std::uint8_t> is_covered(dark.size(), 0);
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                if (std::hypot(right - dx, down - dy) > diameter / 2) continue;
                for (int y = std::max(-dy, 0); y < std::min(height - dy, height); ++y) {
                    for (int x = std::max(-dx, 0); x < std::min(width - dx, width); ++x)
                        is_covered[pixel(width, x, y)] |= dark[pixel(width, x + dx, y + dy)];
                }
            }
        }
        for (std::size_t i = 0; i < covered.size(); ++i) covered[i] += is_covered[i];
    }
    for (float& value : covered) value /= kSamples * kSamples;
    return covered;
}

double mean(const std::vector<float>& values) {
    double sum = 0;
    for (const float value : values) sum += static_cast<double>(value);
    return sum / static_cast<double>(values.size());
}

/// Returns the root mean square of the difference of two pictures, after a blur of 1.5 pixels.
double seen_difference(std::vector<float> a, const std::vector<float>& b, int width, int height) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
    a = blurred(a, width, height, 1.5, inline_executor());
    for (float& value : a) value *= value;
    return std::sqrt(mean(a));
}

/// Returns a picture in which waves become finer from the left to the right, and darker from the top to the bottom.
std::vector<float> waves(int width, int height, float darkest) {
    std::vector<float> wanted;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const double across = static_cast<double>(x) / width, down = static_cast<double>(y) / height;
            wanted.push_back(darkest * static_cast<float>(down * (0.6 + 0.4 * std::sin(30 * across * across))));
        }
    }
    return wanted;
}

Dark found(const std::vector<float>& wanted, int width, int height, const PrintedSpot& spot,
           Executor& executor = inline_executor()) {
    return search_spots(wanted, Dark(wanted.size(), kAnyColour), width, height, spot, {}, executor);
}

TEST(SpotSearch, PrintsTheMeanOfFlatTones) {
    constexpr int kSide = 64;
    for (const double diameter : {1.2, 1.5, 2.0}) {
        const PrintedSpot spot(diameter);
        for (const float share : {0.05f, 0.3f, 0.5f, 0.7f, 0.95f}) {
            const float wanted = share * spot.solid();
            const Dark dark = found(std::vector<float>(kSide * kSide, wanted), kSide, kSide, spot);
            EXPECT_NEAR(mean(printed(dark, kSide, kSide, diameter)), wanted, 0.005) << diameter << ' ' << wanted;
        }
    }
}

TEST(SpotSearch, PrintsWhatThePictureShows) {
    constexpr int kWidth = 120, kHeight = 90;
    constexpr double kDiameter = 1.5;
    const std::vector<float> wanted = waves(kWidth, kHeight, 1);
    const Dark dark = found(wanted, kWidth, kHeight, PrintedSpot(kDiameter));
    EXPECT_LT(seen_difference(printed(dark, kWidth, kHeight, kDiameter), wanted, kWidth, kHeight), 0.013);
    // Pixels that are right for a spot without overlaps print a picture that is far too dark.
    const Dark other = found(wanted, kWidth, kHeight, PrintedSpot(1));
    EXPECT_GT(seen_difference(printed(other, kWidth, kHeight, kDiameter), wanted, kWidth, kHeight), 0.1);
}

TEST(SpotSearch, KeepsGivenPixels) {
    constexpr int kSide = 48;
    Dark given(kSide * kSide, kAnyColour);
    for (std::size_t i = 0; i < given.size(); i += 3) given[i] = i / 3 % 5 == 0 ? 1 : 0;
    const Dark dark = search_spots(waves(kSide, kSide, 1), given, kSide, kSide, PrintedSpot(1.6));
    for (std::size_t i = 0; i < given.size(); i += 3) ASSERT_EQ(dark[i], given[i]) << i;
}

TEST(SpotSearch, GivesTheSameResultOnAnyNumberOfThreads) {
    // More tiles of the search than threads, and sides that are not multiples of any block.
    constexpr int kWidth = 413, kHeight = 301;
    const std::vector<float> wanted = waves(kWidth, kHeight, 1);
    const PrintedSpot spot(1.5);
    const Dark expected = found(wanted, kWidth, kHeight, spot);
    for (const std::size_t threads : {2, 5}) {
        ThreadExecutor executor(threads);
        EXPECT_EQ(found(wanted, kWidth, kHeight, spot, executor), expected) << threads << " threads";
    }
}

TEST(SpotSearch, AcceptsThinPictures) {
    for (const auto& [width, height] : {std::pair{1, 1}, {1, 300}, {300, 1}, {2, 2}, {9, 3}})
        EXPECT_EQ(found(waves(width, height, 1), width, height, PrintedSpot(2)).size(), area(width, height));
}

}  // namespace
}  // namespace ccdt
