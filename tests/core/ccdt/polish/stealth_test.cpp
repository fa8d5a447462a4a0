// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/stealth.h"

#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt {
namespace {

constexpr double kTau = 6.283185307179586;

/// Returns the largest power of the frequencies below the limit, by direct sums.
double largest_power(const Domain& torus, const std::vector<Point>& points) {
    const Point sides = torus.bounds().max - torus.bounds().min;
    const auto count = static_cast<double>(points.size());
    const double end = Stealth::kLimit * std::sqrt(count / (sides.x * sides.y));
    double largest_power = 0;
    for (int j = static_cast<int>(-end * sides.y); j <= end * sides.y; ++j) {
        for (int i = 0; i <= end * sides.x; ++i) {
            const Point f{i / sides.x, j / sides.y};
            if ((i == 0 && j == 0) || dot(f, f) >= end * end) continue;
            std::complex<double> sum;
            for (const Point& p : points) sum += std::polar(1.0, -kTau * dot(f, p));
            largest_power = std::max(largest_power, std::norm(sum) / count);
        }
    }
    return largest_power;
}

/// Returns the least distance relative to that of neighbours in a hexagonal grid.
double least_distance(const Domain& torus, const std::vector<Point>& points) {
    const Point sides = torus.bounds().max - torus.bounds().min;
    double least = 1e9;
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const Point d = points[i] - points[j];
            least = std::min(least, std::hypot(std::remainder(d.x, sides.x), std::remainder(d.y, sides.y)));
        }
    }
    return least * std::sqrt(std::sqrt(3) / 2 * static_cast<double>(points.size()) / (sides.x * sides.y));
}

std::vector<Point> distributed(const Domain& domain, std::size_t sites, Quality quality, const Control& control = {}) {
    return distribute(domain, Density::uniform(), {.sites = sites, .seed = 3, .quality = quality}, control)->points;
}

TEST(Stealth, LeavesNoPowerBelowTheLimit) {
    for (const auto& [sides, sites] :
         {std::pair(Point{1, 1}, 16U), {{1, 1}, 17U}, {{1, 1}, 300U}, {{3, 1}, 48U}, {{300, 5}, 1'000U}}) {
        const Domain torus = Domain::torus(sides.x, sides.y).value();
        const auto points = distributed(torus, sites, Quality::Stealthy);
        EXPECT_LT(largest_power(torus, points), 2 * Stealth::kNegligiblePower) << sites;
        EXPECT_GT(largest_power(torus, distributed(torus, sites, Quality::Best)), 1e-9) << sites;
    }
}

TEST(Stealth, KeepsDistances) {
    const Domain torus = Domain::torus(1, 1).value();
    EXPECT_GT(least_distance(torus, distributed(torus, 2'000, Quality::Stealthy)), 0.8);
}

TEST(Stealth, MovesSitesLittle) {
    const Domain torus = Domain::torus(2, 1).value();
    const auto best = distributed(torus, 500, Quality::Best), silent = distributed(torus, 500, Quality::Stealthy);
    const double spacing = std::sqrt(2.0 / 500);
    for (std::size_t i = 0; i < best.size(); ++i) {
        const Point d = best[i] - silent[i];
        EXPECT_LT(std::hypot(std::remainder(d.x, 2), std::remainder(d.y, 1)), 0.1 * spacing);
    }
}

TEST(Stealth, FindsTheSmallestMoves) {
    // The moves are a gradient field. Any other solution adds a part that changes no sum and makes the moves longer.
    const Domain torus = Domain::torus(1, 1).value();
    const auto sites = distributed(torus, 200, Quality::Draft);
    Stealth stealth(torus, sites.size());
    std::vector<Point> moves(sites.size());
    ASSERT_TRUE(stealth.displacements(sites, moves));
    EXPECT_GT(stealth.largest_power(), 1e-5);
    // To first order, the moves cancel all sums, so a hundredth of each move cancels a hundredth of each sum.
    std::vector<Point> there = sites;
    for (std::size_t i = 0; i < there.size(); ++i) there[i] = there[i] + 0.01 * moves[i];
    std::complex<double> before, after;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        before += std::polar(1.0, -kTau * (2 * sites[i].x + sites[i].y));
        after += std::polar(1.0, -kTau * (2 * there[i].x + there[i].y));
    }
    EXPECT_LT(std::abs(after - 0.99 * before), 0.001 * std::abs(before));
}

TEST(Stealth, AppliesOnlyToSuitableDomains) {
    EXPECT_TRUE(Stealth::fits(Domain::torus(1, 1).value(), 16));
    EXPECT_FALSE(Stealth::fits(Domain::torus(1, 1).value(), 15));
    EXPECT_FALSE(Stealth::fits(Domain::torus(1e-3, 1).value(), 15'000));
    for (const Domain& other : {Domain::rectangle(1, 1).value(), Domain::torus(3, 50).value()})
        EXPECT_EQ(distributed(other, 100, Quality::Stealthy), distributed(other, 100, Quality::Best));
}

TEST(Stealth, IsDeterministic) {
    const Domain torus = Domain::torus(1, 1).value();
    EXPECT_EQ(distributed(torus, 400, Quality::Stealthy), distributed(torus, 400, Quality::Stealthy));
}

TEST(Stealth, StopsOnRequest) {
    const Domain torus = Domain::torus(1, 1).value();
    Stealth stealth(torus, 64);
    std::vector<Point> sites, moves(64);
    Random random(1, 0);
    for (int i = 0; i < 64; ++i) sites.push_back({random.uniform(), random.uniform()});
    std::stop_source source;
    source.request_stop();
    EXPECT_FALSE(stealth.displacements(sites, moves, source.get_token()));
}

TEST(Stealth, ReportsProgressToTheEnd) {
    int round = 0, rounds = -1;
    Control control;
    control.progress = [&](const Progress& progress) {
        round = progress.round;
        rounds = progress.rounds;
    };
    distributed(Domain::torus(1, 1).value(), 100, Quality::Stealthy, control);
    EXPECT_GT(rounds, 0);
    EXPECT_EQ(round, rounds);
}

}  // namespace
}  // namespace ccdt
