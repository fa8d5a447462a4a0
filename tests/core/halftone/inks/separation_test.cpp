// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/separation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/halftone/inks/overprint.h"
#include "core/picture/colour_difference.h"
#include "tests/support/inks.h"

namespace ccdt {
namespace {

using Covers = std::vector<std::vector<float>>;

/// Returns the coverage of a single pixel by each ink.
std::vector<float> mix(const Light& light, const InkSet& inks, Tone tone = Tone::Linear) {
    std::vector<float> cover;
    for (const auto& ink : separate({1, 1, {light.red}, {light.green}, {light.blue}, {}}, inks, tone).coverage) {
        cover.push_back(ink.at(0));
    }
    return cover;
}

void expect_near(const std::vector<float>& cover, const std::vector<float>& expected, float tolerance) {
    ASSERT_EQ(cover.size(), expected.size());
    for (std::size_t i = 0; i < cover.size(); ++i) EXPECT_NEAR(cover[i], expected[i], tolerance) << "ink " << i;
}

TEST(Separation, UsesSingleInkForItsOwnColour) {
    const InkSet inks = test::cmyk_inks();
    expect_near(mix({1, 1, 1}, inks), {0, 0, 0, 0}, 1e-6f);
    expect_near(mix({0, 0, 0}, inks), {0, 0, 0, 1}, 1e-3f);
    expect_near(mix({0, 1, 1}, inks), {1, 0, 0, 0}, 5e-3f);
    expect_near(mix({1, 0, 1}, inks), {0, 1, 0, 0}, 5e-3f);
    expect_near(mix({1, 1, 0}, inks), {0, 0, 1, 0}, 5e-3f);
}

TEST(Separation, LeavesPaperUnderTransparentPixels) {
    const ColourPicture picture{3,         1,         {0, 0, 0},
                                {0, 0, 0}, {0, 0, 0}, {0, 0.5f, std::numeric_limits<float>::quiet_NaN()}};
    const Covers covers = separate(picture, test::cmyk_inks(), Tone::Linear).coverage;
    expect_near(covers[3], {0, 0.5f, 0}, 1e-3f);
}

TEST(Separation, UsesBlackOnlyForGreys) {
    for (const float grey : {0.0f, 0.03f, 0.18f, 0.5f, 0.7f, 0.95f}) {
        const std::vector<float> cover = mix({grey, grey, grey}, test::cmyk_inks());
        for (std::size_t ink = 0; ink < 3; ++ink) EXPECT_EQ(cover[ink], 0) << "ink " << ink << " of grey " << grey;
        EXPECT_NEAR(cover[3], 1 - grey, 3e-3);
    }
}

TEST(Separation, PrintsOneBlackInkAsGrey) {
    const InkSet black{{{0, 0, 0}}, {1, 1, 1}, false};
    for (const Light& light : {Light{0.2f, 0.5f, 0.9f}, Light{1, 0, 0}, Light{0.1f, 0.9f, 0.3f}}) {
        const float luminance = 0.2126f * light.red + 0.7152f * light.green + 0.0722f * light.blue;
        expect_near(mix(light, black), ink_coverage({1, 1, {luminance}, {}}, Tone::Linear, false), 3e-3f);
    }
    const float grey = 0.25f;
    expect_near(mix({grey, grey, grey}, black, Tone::Perceptual),
                ink_coverage({1, 1, {grey}, {}}, Tone::Perceptual, false), 3e-3f);
}

TEST(Separation, ReproducesInkColoursWithPerceptualTone) {
    const InkSet inks{{{1, 0.3f, 0}, {0, 0.1f, 0.4f}}, {1, 1, 1}, false};
    expect_near(mix({1, 0.3f, 0}, inks, Tone::Perceptual), {1, 0}, 3e-2f);
    expect_near(mix({0, 0.1f, 0.4f}, inks, Tone::Perceptual), {0, 1}, 3e-2f);
}

TEST(Separation, ClampsInvalidLight) {
    const float none = std::numeric_limits<float>::quiet_NaN();
    expect_near(mix({none, none, none}, test::cmyk_inks()), {0, 0, 0, 1}, 1e-3f);
    expect_near(mix({2, -1, 2}, test::cmyk_inks()), {0, 1, 0, 0}, 1e-3f);
}

/// Returns the predicted light of a halftone.
Light halftoned(const InkSet& inks, const std::vector<float>& cover) {
    Overprint::Numbers numbers{};
    std::ranges::copy(cover, numbers.begin());
    const auto light = Overprint(inks).light(numbers);
    return {static_cast<float>(light[0]), static_cast<float>(light[1]), static_cast<float>(light[2])};
}

/// Returns a picture with a single row of pixels.
ColourPicture row_of(const std::vector<Light>& lights) {
    const auto plane = [&](float Light::*channel) {
        const auto values = std::make_shared<float[]>(lights.size());
        std::ranges::transform(lights, values.get(), channel);
        return Plane(values, lights.size());
    };
    return {static_cast<int>(lights.size()), 1, plane(&Light::red), plane(&Light::green), plane(&Light::blue), {}};
}

float largest_difference(const Light& a, const Light& b) {
    return std::max({std::abs(a.red - b.red), std::abs(a.green - b.green), std::abs(a.blue - b.blue)});
}

TEST(Separation, MatchesColoursOfPicture) {
    constexpr int kSide = 12;
    std::vector<Light> lights;
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
        const auto share = [](int step) { return static_cast<float>(step) / (kSide - 1); };
        lights.push_back({share(i % kSide), share(i / kSide % kSide), share(i / kSide / kSide)});
    }
    const ColourPicture picture = row_of(lights);
    for (const InkSet& inks : {test::cmyk_inks(), test::rgb_inks()}) {
        const Covers covers = separate(picture, inks, Tone::Linear).coverage;
        for (std::size_t p = 0; p < lights.size(); ++p) {
            std::vector<float> here;
            for (const auto& cover : covers) here.push_back(cover[p]);
            EXPECT_LT(largest_difference(halftoned(inks, here), lights[p]), 0.02f) << p;
        }
    }
}

TEST(Separation, ReproducesDarkColours) {
    for (const Light& light : {Light{0.03f, 0.005f, 0.005f}, {0.004f, 0.012f, 0.02f}, {0.02f, 0.018f, 0.004f}}) {
        const InkSet inks = test::cmyk_inks();
        const Light seen = halftoned(inks, mix(light, inks));
        const ColourDifference difference(lab_of({light.red, light.green, light.blue}));
        for (const double off : difference(lab_of({seen.red, seen.green, seen.blue}))) EXPECT_NEAR(off, 0, 2.5);
    }
}

TEST(Separation, OmitsInksHiddenByBlack) {
    const std::vector<float> cover = mix({0.0022f, 0.0018f, 0.0015f}, test::cmyk_inks());
    EXPECT_GT(cover[3], 0.99f);
    for (std::size_t ink = 0; ink < 3; ++ink) EXPECT_LT(cover[ink], 0.2f) << ink;
}

TEST(Separation, MapsToNearestPrintableColour) {
    const InkSet inks{{{0.8f, 0.05f, 0.02f}, {0, 0, 0}}, {1, 1, 1}, false};
    const std::vector<float> blue = mix({0.05f, 0.1f, 0.6f}, inks), grey = mix({0.2f, 0.2f, 0.2f}, inks);
    EXPECT_LT(blue[0], 0.05f) << "red ink would change the hue";
    EXPECT_NEAR(blue[1], 1 - 0.125f, 0.02f) << "lightness is kept";
    EXPECT_NEAR(grey[1], 0.8f, 5e-3f);
}

TEST(Separation, RecoversMixturesOfPalette) {
    const InkSet inks{{{0.02f, 0.05f, 0.2f}, {0.7f, 0.06f, 0.03f}, {0.9f, 0.6f, 0.05f}}, {1, 0.98f, 0.9f}, false};
    for (const std::vector<float>& cover : {std::vector<float>{0.2f, 0.3f, 0.1f}, {0.6f, 0, 0.4f}, {0, 0.05f, 0.9f}}) {
        expect_near(mix(halftoned(inks, cover), inks), cover, 0.05f);
    }
}

TEST(Separation, IsContinuousInTheColour) {
    const InkSet six{{{0.01f, 0.03f, 0.2f},
                      {0.7f, 0.02f, 0.02f},
                      {0.9f, 0.7f, 0.02f},
                      {0.02f, 0.4f, 0.1f},
                      {0.3f, 0.1f, 0.02f},
                      {0, 0, 0}},
                     {1, 1, 1},
                     false};
    constexpr int kSteps = 2000;
    std::vector<Light> lights;
    for (int i = 0; i < kSteps; ++i) {
        const float t = static_cast<float>(i) / kSteps;
        lights.push_back({t, 0.5f - 0.4f * t, t * t});
    }
    const ColourPicture picture = row_of(lights);
    for (const InkSet& inks : {six, test::cmyk_inks()}) {
        for (const auto& cover : separate(picture, inks, Tone::Linear).coverage) {
            for (std::size_t i = 1; i < kSteps; ++i) EXPECT_LT(std::abs(cover[i] - cover[i - 1]), 0.02f) << i;
        }
    }
}

TEST(Separation, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    const auto covers =
        separate({1, 1, {0}, {0}, {0}, {}}, test::cmyk_inks(), Tone::Linear, source.get_token()).coverage;
    EXPECT_EQ(covers, Covers(4, {0}));
}

TEST(Separation, UsesRgbValuesDirectly) {
    expect_near(mix({0.25f, 0.5f, 0.75f}, test::rgb_inks()), {0.25f, 0.5f, 0.75f}, 0.012f);
}

TEST(ShareSites, ApportionsByLargestRemainder) {
    EXPECT_EQ(share_sites(std::vector<double>{3, 2, 1}, 600), (std::vector<std::size_t>{300, 200, 100}));
    EXPECT_EQ(share_sites(std::vector<double>{1.5, 2.7, 5.8}, 10), (std::vector<std::size_t>{1, 3, 6}));
}

TEST(ShareSites, GivesAtLeastOneToEachUsedInk) {
    EXPECT_EQ(share_sites(std::vector<double>{1000, 0, 1e-9}, 100), (std::vector<std::size_t>{99, 0, 1}));
    EXPECT_EQ(share_sites(std::vector<double>{1, 3, 2}, 2), (std::vector<std::size_t>{0, 1, 1}))
        << "too few sites for all inks";
    EXPECT_EQ(share_sites(std::vector<double>{0, 0}, 5), (std::vector<std::size_t>{0, 0}));
}

TEST(ShareSites, DistributesAllSites) {
    const std::vector<double> sums{1e-12, 17, 1.0 / 3, 1e9, 5, 5};
    for (std::size_t sites = 0; sites < 300; ++sites) {
        const auto shares = share_sites(sums, sites);
        EXPECT_EQ(std::accumulate(shares.begin(), shares.end(), std::size_t{0}), sites);
    }
}

}  // namespace
}  // namespace ccdt
