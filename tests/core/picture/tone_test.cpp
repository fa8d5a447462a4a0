// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/tone.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

TEST(InkCoverage, IsComplementOfReflectance) {
    const Picture picture{2, 2, {0, 1, 0.25f, 0.75f}, {}};
    EXPECT_EQ(ink_coverage(picture, Tone::Linear, false), (std::vector<float>{1, 0, 0.75f, 0.25f}));
    EXPECT_EQ(ink_coverage(picture, Tone::Linear, true), (std::vector<float>{0, 1, 0.25f, 0.75f}));
}

TEST(InkCoverage, LeavesPaperUnderTransparentPixels) {
    const Picture picture{2, 2, {0, 0, 0.5f, 1}, {0, 0.5f, 0.5f, 0}};
    EXPECT_EQ(ink_coverage(picture, Tone::Linear, false), (std::vector<float>{0, 0.5f, 0.25f, 0}));
    EXPECT_EQ(ink_coverage(picture, Tone::Linear, true), (std::vector<float>{0, 0, 0.25f, 0}));
}

TEST(InkCoverage, FollowsLightnessForPerceptualTone) {
    // CIE L* is 50 at Y = 0.184187, and 8 at the end of its linear part, Y = 216 / 24389.
    const Picture picture{5, 1, {0, 1, 0.18418651f, 216.0f / 24389.0f, 108.0f / 24389.0f}, {}};
    const auto coverage = ink_coverage(picture, Tone::Perceptual, false);
    EXPECT_NEAR(coverage[0], 1, 1e-6);
    EXPECT_NEAR(coverage[1], 0, 1e-6);
    EXPECT_NEAR(coverage[2], 0.5, 1e-6);
    EXPECT_NEAR(coverage[3], 0.92, 1e-6);
    EXPECT_NEAR(coverage[4], 0.96, 1e-6);
    EXPECT_NEAR(ink_coverage(picture, Tone::Perceptual, true)[2], 0.5, 1e-6);
}

TEST(Luminance, InvertsLightness) {
    for (const float light : {0.0f, 0.004f, 0.0089f, 0.18f, 1.0f})
        EXPECT_NEAR(luminance(lightness(light)), light, 1e-6);
}

TEST(InkCoverage, ClampsValues) {
    const float none = std::numeric_limits<float>::quiet_NaN();
    const Picture picture{3, 1, {-0.5f, 1.5f, none}, {}};
    EXPECT_EQ(ink_coverage(picture, Tone::Linear, false), (std::vector<float>{1, 0, 1}));
    EXPECT_EQ(ink_coverage(picture, Tone::Perceptual, true), (std::vector<float>{0, 1, 0}));
    const Picture glass{3, 1, {0, 0, 0}, {-0.5f, 1.5f, none}};
    EXPECT_EQ(ink_coverage(glass, Tone::Linear, false), (std::vector<float>{0, 1, 0}));
}

TEST(SitesOfDrawing, GrowWithSquareRootOfPixels) {
    const auto sites = [](double scale) {
        return sites_of_drawing(250'000, 0, scale, 1e6 * scale * scale, kRadiusOfDiscs,
                                std::numeric_limits<std::size_t>::max());
    };
    EXPECT_EQ(sites(1), static_cast<std::size_t>(250'000 / (3.14159265358979 * 9)));
    EXPECT_NEAR(static_cast<double>(sites(4)) / static_cast<double>(sites(1)), 4, 0.001);
    EXPECT_EQ(sites(0.1), static_cast<std::size_t>(2'500 / 3.14159265358979)) << "the radius is at least 1";
}

TEST(SitesOfDrawing, IncreaseUpToFourfoldForFineDetail) {
    const auto sites = [](double fineness) {
        return sites_of_drawing(250'000, fineness, 1, 1e6, kRadiusOfDiscs, 1'000'000);
    };
    EXPECT_EQ(sites(0.05), sites(0));
    EXPECT_NEAR(static_cast<double>(sites(0.12)) / static_cast<double>(sites(0)), 2, 0.001);
    EXPECT_NEAR(static_cast<double>(sites(1)) / static_cast<double>(sites(0)), 4, 0.001);
}

TEST(SitesOfDrawing, AreBounded) {
    EXPECT_EQ(sites_of_drawing(64, 0, 100, 1e6, kRadiusOfDiscs, 1'000'000), 128u) << "two per pixel of ink";
    EXPECT_EQ(sites_of_drawing(1e7, 1, 1, 4e7, kRadiusOfDiscs, 1'000'000), 100'000u);
    EXPECT_EQ(sites_of_drawing(1e7, 1, 1, 4e7, kRadiusOfDiscs, 300), 300u);
    EXPECT_EQ(sites_of_drawing(0, 0, 1, 1, kRadiusOfDiscs, 300), 1u);
    EXPECT_EQ(sites_of_drawing(1, 0, 1e-9, 1, kRadiusOfDiscs, 0), 1u);
}

constexpr std::size_t kNoLimit = 1'000'000;

TEST(DefaultSites, IsOnePerEightPixelsOfInk) {
    EXPECT_EQ(default_sites(80'000, 0, kNoLimit), 10'000u);
    EXPECT_EQ(default_sites(80'000, 0.02, kNoLimit), 10'000u);
}

TEST(DefaultSites, IncreasesForFineDetail) {
    EXPECT_EQ(default_sites(80'000, 0.04, kNoLimit), 20'000u);
    EXPECT_EQ(default_sites(80'000, 0.1, kNoLimit), 50'000u);
    EXPECT_EQ(default_sites(80'000, 1, kNoLimit), 100'000u) << "at most 100,000";
    EXPECT_EQ(default_sites(8'000, 1, kNoLimit), 16'000u) << "at most two per pixel of ink";
    EXPECT_EQ(default_sites(16'000, 0.03, kNoLimit), 4096u) << "at least as many as without fine detail";
}

TEST(DefaultSites, StaysInRange) {
    EXPECT_EQ(default_sites(5'000, 0, kNoLimit), 4096u) << "at least 4,096";
    EXPECT_EQ(default_sites(500, 0, kNoLimit), 500u) << "at most one per pixel of ink";
    EXPECT_EQ(default_sites(2'000'000, 0, kNoLimit), 100'000u) << "at most 100,000";
    EXPECT_EQ(default_sites(2'000'000, 1, 500), 500u) << "at most the limit";
    EXPECT_EQ(default_sites(0, 1, kNoLimit), 1u);
    EXPECT_EQ(default_sites(100, 1, 0), 1u);
}

TEST(DefaultScale, GivesDotRadiusOfThreePixels) {
    // Dots of 2 pixels of ink have a radius of sqrt(2 / pi) = 0.798 pixels.
    EXPECT_EQ(default_scale(5'000, 10'000, 2500), 4);
    // Larger dots need no enlargement.
    EXPECT_EQ(default_scale(10'000, 10'000, 100), 1);
}

TEST(DefaultScale, StaysInRange) {
    EXPECT_EQ(default_scale(0, 100, 10), 16);
    EXPECT_EQ(default_scale(1, 100, 100), 16);
    EXPECT_EQ(default_scale(1e6, 1'000'000, 1), 1);
    EXPECT_NEAR(default_scale(64e6, 64'000'000, 100'000), 0.5, 1e-9);
    const double scale = default_scale(4e6, 4'000'000, 4'000'000);
    EXPECT_NEAR(scale * scale * 4e6, 16e6, 1);
}

}  // namespace
}  // namespace ccdt
