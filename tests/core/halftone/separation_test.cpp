#include "core/halftone/separation.h"

#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

using Covers = std::vector<std::vector<float>>;

/// What the inks cover of one pixel.
std::vector<float> mix(const Light& light, const InkSet& inks, Tone tone = Tone::Linear) {
    std::vector<float> cover;
    for (const auto& ink : separate({1, 1, {light.red}, {light.green}, {light.blue}, {}}, inks, tone)) {
        cover.push_back(ink.at(0));
    }
    return cover;
}

void expect_near(const std::vector<float>& cover, const std::vector<float>& expected, float tolerance) {
    ASSERT_EQ(cover.size(), expected.size());
    for (std::size_t i = 0; i < cover.size(); ++i) EXPECT_NEAR(cover[i], expected[i], tolerance) << "ink " << i;
}

TEST(Separation, CoversWithOneInkWhereThePictureHasItsColour) {
    const InkSet inks = cmyk_inks();
    expect_near(mix({1, 1, 1}, inks), {0, 0, 0, 0}, 1e-6f);
    expect_near(mix({0, 0, 0}, inks), {0, 0, 0, 1}, 1e-3f);
    expect_near(mix({0, 1, 1}, inks), {1, 0, 0, 0}, 1e-3f);
    expect_near(mix({1, 0, 1}, inks), {0, 1, 0, 0}, 1e-3f);
    expect_near(mix({1, 1, 0}, inks), {0, 0, 1, 0}, 1e-3f);
}

TEST(Separation, LeavesTransparentPixelsToThePaper) {
    const ColourPicture picture{3,         1,         {0, 0, 0},
                                {0, 0, 0}, {0, 0, 0}, {0, 0.5f, std::numeric_limits<float>::quiet_NaN()}};
    const Covers covers = separate(picture, cmyk_inks(), Tone::Linear);
    expect_near(covers[3], {0, 0.5f, 0}, 1e-3f);
}

TEST(Separation, TakesRedGreenAndBlueAsTheyAre) {
    expect_near(mix({0.25f, 0.5f, 0.75f}, rgb_inks()), {0.25f, 0.5f, 0.75f}, 1e-3f);
}

TEST(ShareSites, GivesEachInkItsPartByLargestRemainders) {
    EXPECT_EQ(share_sites(std::vector<double>{3, 2, 1}, 600), (std::vector<std::size_t>{300, 200, 100}));
    EXPECT_EQ(share_sites(std::vector<double>{1.5, 2.7, 5.8}, 10), (std::vector<std::size_t>{1, 3, 6}));
}

TEST(ShareSites, GivesOneToEachInkThatCovers) {
    EXPECT_EQ(share_sites(std::vector<double>{1000, 0, 1e-9}, 100), (std::vector<std::size_t>{99, 0, 1}));
    EXPECT_EQ(share_sites(std::vector<double>{1, 3, 2}, 2), (std::vector<std::size_t>{0, 1, 1}))
        << "not enough for all";
    EXPECT_EQ(share_sites(std::vector<double>{0, 0}, 5), (std::vector<std::size_t>{0, 0}));
}

TEST(ShareSites, SharesExactlyAsManyAsThereAre) {
    const std::vector<double> sums{1e-12, 17, 1.0 / 3, 1e9, 5, 5};
    for (std::size_t sites = 0; sites < 300; ++sites) {
        const auto shares = share_sites(sums, sites);
        EXPECT_EQ(std::accumulate(shares.begin(), shares.end(), std::size_t{0}), sites);
    }
}

}  // namespace
}  // namespace ccdt
