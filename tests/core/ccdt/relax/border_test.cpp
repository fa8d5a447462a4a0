// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/border.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace ccdt {
namespace {

std::size_t vertices_between_corners(const Domain& domain, std::size_t sites) {
    const auto border = make_border(domain, CapacityIntegral(domain, Density::uniform()), sites);
    return static_cast<std::size_t>(std::ranges::count(border.corner, false));
}

TEST(Border, HasVerticesAtTheSpacingOfSites) {
    constexpr std::size_t kSites = 10'000;
    const auto vertices = static_cast<double>(vertices_between_corners(*Domain::rectangle(1, 1), kSites));
    const double spacing = std::sqrt(2 / std::sqrt(3.0) / kSites);
    EXPECT_NEAR(vertices, 4 / spacing, 8);
}

TEST(Border, HasAtMostOneVertexPerSiteAlongAThinDomain) {
    constexpr std::size_t kSites = 10'000;
    for (const double width : {1e-6, 1e-5, 1e-4}) {
        const auto vertices = vertices_between_corners(*Domain::rectangle(1, width), kSites);
        EXPECT_LE(vertices, kSites + 64) << width;
        EXPECT_GE(vertices, kSites) << width;
    }
}

TEST(Border, DividesALongEdgeBesideManyShortOnes) {
    constexpr int kTeeth = 20'000;
    constexpr std::size_t kSites = 100;
    Ring comb{{0, 0}, {1, 0}, {1, 1}};
    for (int i = kTeeth; i-- > 0;) {
        const double x = static_cast<double>(i) / kTeeth;
        comb.push_back({x + 0.5 / kTeeth, 0.9});
        comb.push_back({x, 1});
    }
    const auto domain = Domain::create({{{comb, {}}}});
    ASSERT_TRUE(domain);
    EXPECT_GE(vertices_between_corners(*domain, kSites), 15U);
}

}  // namespace
}  // namespace ccdt
