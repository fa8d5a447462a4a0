// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/sharpening.h"

#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/picture/blur.h"

namespace ccdt {
namespace {

constexpr int kWidth = 60, kHeight = 40;
constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;

double sum(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Returns a coverage whose left half is light and whose right half is dark.
std::vector<float> edge(float light, float dark) {
    std::vector<float> cover(kPixels);
    for (std::size_t i = 0; i < kPixels; ++i) cover[i] = i % kWidth < kWidth / 2 ? light : dark;
    return cover;
}

double distance(const std::vector<float>& a, const std::vector<float>& b) {
    double squares = 0;
    for (std::size_t i = 0; i < a.size(); ++i) squares += std::pow(static_cast<double>(a[i] - b[i]), 2);
    return std::sqrt(squares / static_cast<double>(a.size()));
}

TEST(Sharpened, CompensatesForBlur) {
    const auto check = [](const std::vector<float>& cover, double most) {
        const std::vector<float> sharp = sharpened(cover, kWidth, kHeight, 1.5);
        const double before = distance(blurred(cover, kWidth, kHeight, 1.5), cover);
        EXPECT_LT(distance(blurred(sharp, kWidth, kHeight, 1.5), cover), most * before);
    };
    check(edge(0.2F, 0.7F), 0.95);
    std::vector<float> waves(kPixels);
    for (std::size_t i = 0; i < kPixels; ++i)
        waves[i] =
            0.5F + 0.2F * std::sin(static_cast<float>(i % kWidth)) * std::cos(static_cast<float>(i / kWidth) / 3);
    check(waves, 0.9);
}

TEST(Sharpened, PreservesSums) {
    Random random(5, 0);
    std::vector<float> cover(kPixels);
    for (float& each : cover) each = static_cast<float>(0.6 * random.uniform());
    const std::vector<float> sharp = sharpened(cover, kWidth, kHeight, 2);
    EXPECT_NEAR(sum(sharp) / sum(cover), 1, 0.002);
    EXPECT_LT(distance(blurred(sharp, kWidth, kHeight, 8), blurred(cover, kWidth, kHeight, 8)), 0.002);
}

TEST(Sharpened, LeavesFlatAndEmptyAreasUnchanged) {
    const std::vector<float> flat(kPixels, 0.3F);
    const std::vector<float> sharp = sharpened(flat, kWidth, kHeight, 2);
    for (const float each : sharp) EXPECT_NEAR(each, 0.3F, 1e-6F);
    const std::vector<float> white = sharpened(edge(0, 0.9F), kWidth, kHeight, 2);
    for (std::size_t i = 0; i < kPixels; ++i) {
        if (i % kWidth < kWidth / 2) {
            EXPECT_EQ(white[i], 0) << i;
        }
    }
}

TEST(Sharpened, LeavesBlackOnWhiteUnchanged) {
    const std::vector<float> cover = edge(0, 1);
    EXPECT_EQ(sharpened(cover, kWidth, kHeight, 2), cover);
}

TEST(Sharpened, IsIdentityForZeroBlur) {
    const std::vector<float> cover = edge(0.1F, 0.8F);
    EXPECT_EQ(sharpened(cover, kWidth, kHeight, 0), cover);
}

TEST(Sharpened, AcceptsTinyCoverage) {
    for (const float least : {1e-45F, 1e-20F, 1e-7F}) {
        std::vector<float> cover(kPixels, 0.0F);
        cover[777] = least;
        EXPECT_GT(sharpened(cover, kWidth, kHeight, 3)[777], 0) << least;
        cover[778] = 1;
        for (const float each : sharpened(cover, kWidth, kHeight, 3)) EXPECT_TRUE(each >= 0 && each <= 1) << least;
    }
}

}  // namespace
}  // namespace ccdt
