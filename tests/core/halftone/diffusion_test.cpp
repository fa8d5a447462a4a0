// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/diffusion.h"

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace ccdt {
namespace {

using Shares = std::vector<std::uint8_t>;

double sum(const Shares& shares) {
    return std::accumulate(shares.begin(), shares.end(), 0.0);
}

TEST(Diffuse, PreservesSum) {
    Random random(1, 0);
    for (const auto& [width, height] : {std::pair{64, 48}, {1, 200}, {200, 1}}) {
        Shares shares(static_cast<std::size_t>(width * height));
        for (auto& share : shares) share = static_cast<std::uint8_t>(256 * random.uniform());
        const double before = sum(shares);
        diffuse(shares, width, height);
        for (const auto share : shares) ASSERT_TRUE(share == 0 || share == 255);
        EXPECT_NEAR(sum(shares), before, 2 * 255);
    }
}

TEST(Diffuse, PreservesLocalSums) {
    constexpr int kSide = 64;
    Shares shares(kSide * kSide);
    for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = static_cast<std::uint8_t>(1 + 3 * (i % kSide));
    Shares result = shares;
    diffuse(result, kSide, kSide);
    for (std::size_t x = 0; x < kSide; x += 8) {
        double wanted = 0, made = 0;
        for (std::size_t i = 0; i < shares.size(); ++i) {
            if (i % kSide / 8 * 8 != x) continue;
            wanted += shares[i];
            made += result[i];
        }
        EXPECT_NEAR(made, wanted, 0.02 * 255 * 8 * kSide) << x;
    }
}

TEST(Diffuse, LeavesEmptyAndFullPixelsUnchanged) {
    Random random(2, 0);
    Shares shares(50 * 40);
    for (auto& share : shares) {
        const double kind = random.uniform();
        share = kind < 0.4 ? 0 : kind < 0.7 ? 255 : static_cast<std::uint8_t>(256 * random.uniform());
    }
    Shares result = shares;
    diffuse(result, 50, 40);
    for (std::size_t i = 0; i < shares.size(); ++i) {
        if (shares[i] == 0 || shares[i] == 255) {
            EXPECT_EQ(result[i], shares[i]);
        }
    }
    EXPECT_NEAR(sum(result), sum(shares), 2 * 255);
}

TEST(Diffuse, PassesErrorsOverEmptyAndFullPixels) {
    Shares shares{128, 0, 255, 0, 128, 255};
    diffuse(shares, 6, 1);
    EXPECT_EQ(shares, (Shares{255, 0, 255, 0, 0, 255}));
}

}  // namespace
}  // namespace ccdt
