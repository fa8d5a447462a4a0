// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/ink_mixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "core/picture/colour_difference.h"
#include "core/picture/tone.h"

namespace ccdt {
namespace {

const InkSet kIdeal{{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}}};
const InkSet kRiso{{{1, 0.06F, 0.43F}, {0, 0.19F, 0.52F}, {1, 0.81F, 0}, {0, 0, 0}}};

Light as_light(const Overprint::Channels& channels) {
    return {static_cast<float>(channels[0]), static_cast<float>(channels[1]), static_cast<float>(channels[2])};
}

double difference(const Light& wanted, const Overprint::Channels& seen) {
    const Lab off = ColourDifference(lab_of(Overprint::channels_of(wanted)))(lab_of(seen));
    return std::sqrt(dot(off, off));
}

TEST(InkMixture, SortsSetsFromDarkToLight) {
    EXPECT_EQ(sets_by_luminance(kIdeal), (std::vector<unsigned>{7, 3, 6, 2, 5, 1, 4, 0}));
    EXPECT_EQ(light_of_set(kIdeal, 5), (Light{0, 1, 0}));
}

TEST(InkMixture, ReproducesColoursWithinTheGamut) {
    for (const InkSet& inks : {kIdeal, kRiso}) {
        const InkMixture mixture(inks, sets_by_luminance(inks));
        InkMixture::Shares shares{};
        for (int i = 0; i < 40; ++i) {
            // Each colour is a mixture of four sets.
            shares = {};
            for (std::size_t k = 0; k < 4; ++k)
                shares[(static_cast<std::size_t>(i) * 7 + k * 3) % mixture.count()] += 0.25F;
            const Light wanted = as_light(mixture.light(shares));
            const auto found = mixture.solve(wanted);
            EXPECT_LT(difference(wanted, mixture.light(found)), 0.3) << i;
            EXPECT_NEAR(std::accumulate(found.begin(), found.end(), 0.0F), 1, 1e-5F);
            EXPECT_GE(*std::ranges::min_element(found), 0);
        }
    }
}

TEST(InkMixture, PrefersSetsThatLookLikeTheColour) {
    const std::vector<unsigned> sets = sets_by_luminance(kRiso);
    const InkMixture mixture(kRiso, sets);
    for (std::size_t set = 0; set < sets.size(); ++set) {
        if (sets[set] >= 7) continue;  // these are all nearly black
        EXPECT_GT(mixture.solve(light_of_set(kRiso, sets[set]))[set], 0.95F) << sets[set];
    }
}

TEST(InkMixture, ChangesLittleWithTheColour) {
    const InkMixture mixture(kRiso, sets_by_luminance(kRiso));
    auto before = mixture.solve({0.2F, 0.2F, 0.2F});
    for (float light = 0.205F; light < 0.6F; light += 0.005F) {
        const auto shares = mixture.solve({light, light, light});
        for (std::size_t set = 0; set < mixture.count(); ++set) EXPECT_NEAR(shares[set], before[set], 0.02F) << light;
        before = shares;
    }
}

TEST(InkMixture, FindsTheNearestColoursOutsideTheGamut) {
    const InkSet riso{{kRiso.inks.begin(), kRiso.inks.begin() + 3}};
    for (const InkSet& inks : {InkSet{{{0, 0.19F, 0.52F}}}, riso}) {
        const InkMixture mixture(inks, sets_by_luminance(inks));
        for (int i = 0; i < 343; ++i) {
            const auto level = [](int step) { return luminance(static_cast<float>(step) / 6); };
            const Light wanted{level(i % 7), level(i / 7 % 7), level(i / 49)};
            const double found = difference(wanted, mixture.light(mixture.solve(wanted)));
            double least = found;
            for (std::size_t a = 0; a < mixture.count(); ++a) {
                for (std::size_t b = 0; b < a; ++b) {
                    for (float share = 0; share < 1.05F; share += 0.1F) {
                        InkMixture::Shares shares{};
                        shares[a] = share;
                        shares[b] = 1 - share;
                        least = std::min(least, difference(wanted, mixture.light(shares)));
                    }
                }
            }
            EXPECT_LT(found, least + 0.2) << wanted.red << ' ' << wanted.green << ' ' << wanted.blue;
        }
    }
}

}  // namespace
}  // namespace ccdt
