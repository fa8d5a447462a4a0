// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/kind_mixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

std::vector<unsigned> all_kinds(std::size_t inks) {
    std::vector<unsigned> kinds((std::size_t{1} << inks) - 1);
    std::iota(kinds.begin(), kinds.end(), 1U);
    return kinds;
}

const InkSet kIdeal{{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}}};
const InkSet kRiso{{{1, 0.06F, 0.43F}, {0, 0.19F, 0.52F}, {1, 0.81F, 0}, {0, 0, 0}}};

/// Returns the mean light of a ground with dots on it.
/// @param shares  [kinds] share that the dots of each kind cover
std::array<float, 3> mixed(const InkSet& inks, const KindMixture& mixture, unsigned ground,
                           const KindMixture::Shares& shares) {
    std::vector<float> cover;
    for (std::size_t i = 0; i < inks.inks.size(); ++i) cover.push_back(static_cast<float>(ground >> i & 1));
    const auto [red, green, blue] = printed(inks, cover);
    std::array<float, 3> light{red, green, blue};
    for (std::size_t k = 0; k < mixture.count(); ++k) {
        const auto change = mixture.change(ground, k);
        for (std::size_t c = 0; c < 3; ++c) light[c] += shares[k] * change[c];
    }
    return light;
}

TEST(KindMixture, NestsFlippedAreasOfIdealInks) {
    KindMixture mixture(kIdeal, all_kinds(3));
    for (const std::array light : {std::array{0.9F, 0.7F, 0.6F}, std::array{0.8F, 0.1F, 0.3F},
                                   std::array{0.05F, 0.1F, 0.2F}, std::array{0.55F, 0.45F, 0.9F}}) {
        unsigned ground = 0;
        float most = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            ground |= static_cast<unsigned>(light[c] < 0.5F) << c;
            most = std::max(most, std::min(light[c], 1 - light[c]));
        }
        const auto shares = mixture.shares(ground, {light[0], light[1], light[2]});
        const auto seen = mixed(kIdeal, mixture, ground, shares);
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], light[c], 0.004F) << light[0] << ' ' << c;
        EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0F), most, 0.06F) << light[0];
    }
}

TEST(KindMixture, ReproducesPrintableColoursOfAnyInks) {
    KindMixture mixture(kRiso, all_kinds(4));
    for (const unsigned ground : {0U, 2U, 5U, 8U, 10U}) {
        KindMixture::Shares shares{};
        shares[0] = 0.1F;
        shares[6] = 0.15F;
        shares[14] = 0.2F;
        const auto wanted = mixed(kRiso, mixture, ground, shares);
        const auto seen = mixed(kRiso, mixture, ground, mixture.shares(ground, {wanted[0], wanted[1], wanted[2]}));
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], wanted[c], 0.01F) << ground << ' ' << c;
    }
}

TEST(KindMixture, LimitsTotalCover) {
    KindMixture mixture(kRiso, all_kinds(4));
    for (unsigned ground = 0; ground < 16; ++ground) {
        for (int i = 0; i < 27; ++i) {
            const Light light{static_cast<float>(i % 3) / 2, static_cast<float>(i / 3 % 3) / 2,
                              static_cast<float>(i / 9) / 2};
            const auto shares = mixture.shares(ground, light);
            float sum = 0;
            for (const float share : shares) {
                EXPECT_TRUE(std::isfinite(share) && share >= 0);
                sum += share;
            }
            EXPECT_LE(sum, KindMixture::kMaxCover + 0.01) << ground << ' ' << i;
        }
    }
}

TEST(KindMixture, OmitsInvisibleDots) {
    KindMixture mixture(kRiso, all_kinds(4));
    const auto shares = mixture.shares(8, {0.1F, 0.1F, 0.1F});
    for (std::size_t k = 0; k < mixture.count(); ++k) {
        if (((k + 1) & 8) == 0) {
            EXPECT_NEAR(shares[k], 0, 1e-4F) << "hidden by black ground: " << k;
        }
    }
}

}  // namespace
}  // namespace ccdt
