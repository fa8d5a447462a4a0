// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/transport.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/ccdt/plane/ccdt.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::grid_of;

constexpr double kPi = 3.141592653589793;
constexpr std::size_t kSites = 3600;

Density waves() {
    return grid_of(90, 90, [](int i, int j) {
        return 1 + 0.5 * std::sin(2 * kPi * (i + 0.5) / 90) * std::cos(2 * kPi * (j + 0.5) / 90);
    });
}

/// Returns the amplitude of the wave cos(column pi x) in the distribution of sites, or in a density.
double amplitude(const std::vector<Point>& sites, int column) {
    double sum = 0;
    for (const Point p : sites) sum += std::cos(kPi * column * p.x);
    return sum / static_cast<double>(sites.size());
}

double amplitude(const Density& density, int column) {
    if (density.is_uniform()) return 0;
    double sum = 0;
    for (int j = 0; j < density.height(); ++j) {
        for (int i = 0; i < density.width(); ++i) {
            sum += density.value(i, j) * std::cos(kPi * column * (i + 0.5) / density.width());
        }
    }
    return sum / density.total();
}

/// Returns the share of a long wave's error that remains after one round.
double remaining_share(const Domain& domain, const Density& density, int column) {
    auto sites = distribute(domain, density, {.sites = kSites, .seed = 3})->points;
    // The moves are shorter than the limit of a round. To first order, they add pi column longest cos(pi column x) to a
    // uniform density.
    const double longest = 0.15 / std::sqrt(static_cast<double>(kSites));
    for (Point& p : sites) p.x -= longest * std::sin(kPi * column * p.x);
    const double wanted = amplitude(density, column), before = amplitude(sites, column) - wanted;
    EXPECT_GT(before, 0.4 * kPi * column * longest);
    Transport transport(domain, density, kSites);
    std::vector<Point> moves(kSites);
    transport.displacements(sites, moves);
    for (std::size_t i = 0; i < kSites; ++i) sites[i] = sites[i] + moves[i];
    return std::abs(amplitude(sites, column) - wanted) / before;
}

TEST(Transport, RemovesALongWave) {
    const Domain box = Domain::rectangle(1, 1).value(), torus = Domain::torus(1, 1).value();
    for (const int column : {2, 4, 8, 14}) {
        SCOPED_TRACE(column);
        EXPECT_LT(remaining_share(box, Density::uniform(), column), 0.05);
        EXPECT_LT(remaining_share(torus, Density::uniform(), column), 0.05);
        EXPECT_LT(remaining_share(box, waves(), column), 0.1);
        EXPECT_LT(remaining_share(torus, waves(), column), 0.1);
    }
    // A box also has waves with half a period.
    EXPECT_LT(remaining_share(box, Density::uniform(), 3), 0.05);
    EXPECT_LT(remaining_share(box, waves(), 5), 0.1);
}

TEST(Transport, ReportsAStop) {
    const Domain domain = Domain::rectangle(1, 1).value();
    const auto sites = distribute(domain, Density::uniform(), {.sites = 100, .iterations = 0})->points;
    std::vector<Point> moves(sites.size());
    Transport transport(domain, Density::uniform(), sites.size());
    std::stop_source source;
    EXPECT_TRUE(transport.displacements(sites, moves, source.get_token()));
    source.request_stop();
    EXPECT_FALSE(transport.displacements(sites, moves, source.get_token()));
}

TEST(Transport, ContinuesAfterAReleaseOfMemory) {
    for (const Domain& domain : {Domain::rectangle(1, 1).value(), Domain::torus(1, 1).value()}) {
        const Density density = waves();
        const auto sites = distribute(domain, density, {.sites = kSites, .seed = 4, .quality = Quality::Draft})->points;
        Transport transport(domain, density, kSites);
        std::vector<Point> before(kSites), after(kSites);
        ASSERT_TRUE(transport.displacements(sites, before));
        transport.release_memory();
        ASSERT_TRUE(transport.displacements(sites, after));
        EXPECT_EQ(before, after);
    }
}

TEST(Transport, KeepsALattice) {
    constexpr int kSide = 60;
    std::vector<Point> sites;
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) sites.push_back({(i + 0.5) / kSide, (j + 0.5) / kSide});
    }
    std::vector<Point> moves(sites.size());
    for (const Domain& domain : {Domain::rectangle(1, 1).value(), Domain::torus(1, 1).value()}) {
        Transport transport(domain, Density::uniform(), sites.size());
        transport.displacements(sites, moves);
        for (const Point move : moves) ASSERT_LT(std::sqrt(dot(move, move)), 1e-3 / kSide);
    }
}

TEST(Transport, LimitsMovesToAQuarterOfTheSpacing) {
    Random random(4, 0);
    const Density noise = grid_of(40, 40, [&](int, int) { return std::pow(10.0, -4 * random.uniform()); });
    std::vector<Point> sites(kSites), moves(kSites);
    for (Point& p : sites) p = {random.uniform() * random.uniform(), random.uniform()};
    for (const Domain& domain : {Domain::rectangle(1, 1).value(), Domain::torus(1, 1).value()}) {
        for (const Density& density : {Density::uniform(), noise}) {
            Transport transport(domain, density, kSites);
            transport.displacements(sites, moves);
            double longest = 0;
            for (std::size_t i = 0; i < kSites; ++i) {
                longest = std::max(longest, std::sqrt(dot(moves[i], moves[i])) / transport.spacing(sites[i]));
            }
            EXPECT_LE(longest, 0.25 * (1 + 1e-12));
            EXPECT_GT(longest, 0.2) << "half of the sites are where a quarter of them should be";
        }
    }
}

TEST(Transport, ComputesTheLocalSpacing) {
    const Domain box = Domain::rectangle(2, 1).value();
    EXPECT_DOUBLE_EQ(Transport(box, Density::uniform(), 200).spacing({0.3, 0.2}), 0.05);
    const Density halves = grid_of(2, 1, [](int i, int) { return i == 0 ? 1.0 : 4.0; });
    const Transport transport(box, halves, 10'000);
    EXPECT_NEAR(transport.spacing({0.25, 0.25}), std::sqrt(0.25 / 2000), 1e-3 * std::sqrt(0.25 / 2000));
    EXPECT_NEAR(transport.spacing({0.75, 0.25}), std::sqrt(0.25 / 8000), 1e-3 * std::sqrt(0.25 / 8000));
}

TEST(Transport, ComputesTheLocalSpacingInCrowds) {
    const Domain box = Domain::rectangle(1, 1).value();
    const Density spots =
        grid_of(500, 500, [](int i, int j) { return (i < 5 && j < 5) || (i >= 490 && j >= 490) ? 1.0 : 0.0; });
    const Transport transport(box, spots, 12'500);
    for (const Point p : {Point{0.005, 0.005}, Point{0.99, 0.99}})
        EXPECT_NEAR(transport.spacing(p), 0.0002, 1e-6) << "100 sites per cell";
}

TEST(Transport, IgnoresEmptyMargins) {
    const auto wave = [](int i, int j) { return 1 + 0.5 * std::sin(0.3 * i) * std::cos(0.2 * j); };
    const Density tight = grid_of(40, 40, wave);
    const Density wide = grid_of(
        160, 80, [&](int i, int j) { return i >= 20 && i < 60 && j >= 8 && j < 48 ? wave(i - 20, j - 8) : 0.0; });
    const Domain small = Domain::rectangle(1, 1).value(), page = Domain::rectangle(4, 2).value();
    const auto sites = distribute(small, tight, {.sites = 900, .iterations = 1})->points;
    std::vector<Point> moves(sites.size()), moves_on_page(sites.size()), on_page;
    for (const Point p : sites) on_page.push_back({0.25 * (p.x + 0.5), 0.25 * (p.y + 0.2)});
    ASSERT_TRUE(Transport(small, tight, sites.size()).displacements(sites, moves));
    ASSERT_TRUE(Transport(page, wide, sites.size()).displacements(on_page, moves_on_page));
    double longest = 0;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        longest = std::max(longest, std::sqrt(dot(moves[i], moves[i])));
        const Point off = moves[i] - 4 * moves_on_page[i];
        EXPECT_LT(std::sqrt(dot(off, off)), 1e-6);
    }
    EXPECT_GT(longest, 1e-4);
}

/// A site's move does not depend on where the torus is cut.
TEST(Transport, IsInvariantUnderShifts) {
    const Domain torus = Domain::torus(1, 1).value();
    Random random(5, 0);
    std::vector<Point> sites(500), moves(500), moved_moves(500);
    for (Point& p : sites) p = {random.uniform(), random.uniform()};
    // Shifts by whole cells of any grid whose size is a multiple of 2, so that the spline's own error is the same.
    std::vector<Point> moved = sites;
    for (Point& p : moved) p = p + Point{0.5, -0.5};
    for (const bool uniform : {true, false}) {
        const auto value = [](int i, int j) { return 1 + 0.5 * std::sin(0.3 * i) + (j > 20 ? 1 : 0); };
        const Density density = uniform ? Density::uniform() : grid_of(40, 40, value);
        const Density shifted =
            uniform ? Density::uniform()
                    : grid_of(40, 40, [&](int i, int j) { return value((i + 20) % 40, (j + 20) % 40); });
        Transport(torus, density, 500).displacements(sites, moves);
        Transport(torus, shifted, 500).displacements(moved, moved_moves);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            EXPECT_NEAR(moves[i].x, moved_moves[i].x, 1e-9);
            EXPECT_NEAR(moves[i].y, moved_moves[i].y, 1e-9);
        }
    }
}

/// With cells as wide as the box is high, the grid would take gigabytes.
TEST(Transport, LimitsTheMemoryForThinBoxes) {
    constexpr std::size_t kInLine = 100'000;
    const double height = 1e-10;
    const Domain domain = Domain::rectangle(1, height).value();
    std::vector<Point> sites, moves(kInLine);
    for (std::size_t i = 0; i < kInLine; ++i) {
        sites.push_back({(static_cast<double>(i) + 0.5) / static_cast<double>(kInLine), height / 2});
    }
    Transport transport(domain, Density::uniform(), kInLine);
    EXPECT_TRUE(transport.displacements(sites, moves));
    for (const Point& move : moves) EXPECT_NEAR(move.x, 0, 1e-9);
}

}  // namespace
}  // namespace ccdt
