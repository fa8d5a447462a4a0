// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/ink_push.h"

#include <cmath>
#include <stop_token>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/geometry/hexagonal_spacing.h"

namespace ccdt {
namespace {

constexpr double kSpacing = 0.1;
const double kNeighbour = kSpacing * hexagonal_spacing(1);
const Domain kBox = Domain::rectangle(1, 1).value();
const Domain kTorus = Domain::torus(1, 1).value();

TEST(InkPush, DividesTheMissingDistanceBetweenInks) {
    const double apart = 0.3 * kNeighbour;
    const std::vector<InkSite> sites{{{0.5, 0.5}, kSpacing, 0}, {{0.5 + apart, 0.5}, kSpacing, 1}};
    const auto moves = push_inks_apart(kBox, sites, 0.8, 0.25);
    EXPECT_NEAR(moves[0].x, -0.25 * 0.5 * kNeighbour, 1e-12);
    EXPECT_NEAR(moves[1].x, 0.25 * 0.5 * kNeighbour, 1e-12);
    EXPECT_EQ(moves[0].y, 0);
    EXPECT_EQ(moves[1].y, 0);
}

TEST(InkPush, MovesSitesOfSparseInksFarther) {
    const std::vector<InkSite> sites{{{0.5, 0.5}, kSpacing, 0, 1}, {{0.5 + 0.3 * kNeighbour, 0.5}, kSpacing, 1, 2}};
    const auto moves = push_inks_apart(kBox, sites, 0.8, 0.25);
    EXPECT_NEAR(moves[0].x, -0.4 * 0.25 * 0.5 * kNeighbour, 1e-12);
    EXPECT_NEAR(moves[1].x, 1.6 * 0.25 * 0.5 * kNeighbour, 1e-12);
}

TEST(InkPush, IgnoresDistantSitesAndThoseOfTheSameInk) {
    const std::vector<InkSite> sites{{{0.5, 0.5}, kSpacing, 0},
                                     {{0.5, 0.5 + 0.1 * kNeighbour}, kSpacing, 0},
                                     {{0.5, 0.5 - 0.95 * kNeighbour}, kSpacing, 1}};
    for (const Point& move : push_inks_apart(kBox, sites, 0.9, 0.25)) EXPECT_EQ(move, Point{});
}

TEST(InkPush, SeparatesCoincidentSites) {
    const std::vector<InkSite> sites(2, {{0.5, 0.5}, kSpacing, 0});
    std::vector<InkSite> inks = sites;
    inks[1].ink = 1;
    const auto moves = push_inks_apart(kBox, inks, 1, 0.25);
    for (const Point& move : moves) EXPECT_NEAR(std::sqrt(dot(move, move)), 0.25 * kNeighbour, 1e-12);
    const Point between = moves[1] - moves[0];
    EXPECT_GT(dot(between, between), std::pow(0.25 * kNeighbour, 2));
}

/// Computes the moves by comparing all pairs.
std::vector<Point> pushed_one_by_one(bool torus, const std::vector<InkSite>& sites, double reach, double push) {
    std::vector<Point> moves(sites.size());
    for (std::size_t a = 0; a < sites.size(); ++a) {
        const double least = reach * hexagonal_spacing(1) * sites[a].spacing;
        for (const InkSite& other : sites) {
            if (other.ink == sites[a].ink) continue;
            Point apart = sites[a].position - other.position;
            if (torus) apart = {apart.x - std::round(apart.x), apart.y - std::round(apart.y)};
            const double distance = std::sqrt(dot(apart, apart));
            if (distance < least) moves[a] = moves[a] + (push * (least / distance - 1)) * apart;
        }
    }
    return moves;
}

TEST(InkPush, EqualsTheComparisonOfAllPairs) {
    Random random(3, 0);
    std::vector<InkSite> sites;
    for (std::uint32_t i = 0; i < 500; ++i) {
        sites.push_back({{random.uniform(), random.uniform()}, 0.02 + 0.05 * random.uniform(), i % 3});
    }
    for (const bool torus : {false, true}) {
        const auto moves = push_inks_apart(torus ? kTorus : kBox, sites, 0.9, 0.3);
        const auto expected = pushed_one_by_one(torus, sites, 0.9, 0.3);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            EXPECT_NEAR(moves[i].x, expected[i].x, 1e-9) << i;
            EXPECT_NEAR(moves[i].y, expected[i].y, 1e-9) << i;
        }
    }
}

TEST(InkPush, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    const std::vector<InkSite> sites{{{0.5, 0.5}, kSpacing, 0}, {{0.51, 0.5}, kSpacing, 1}};
    for (const Point& move : push_inks_apart(kBox, sites, 0.9, 0.3, source.get_token())) EXPECT_EQ(move, Point{});
}

}  // namespace
}  // namespace ccdt
