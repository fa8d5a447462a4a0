// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/error_grid.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/meshes.h"

namespace ccdt {
namespace {

/// Returns the border of a square of 0.8 x 0.8 at the centre of the unit square.
std::vector<BorderEdge> square() {
    const Point a{0.1, 0.1}, b{0.9, 0.1}, c{0.9, 0.9}, d{0.1, 0.9};
    return {{a, b}, {b, c}, {c, d}, {d, a}};
}

std::vector<Point> lattice(int side) {
    std::vector<Point> sites;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) sites.push_back({0.1 + 0.8 * (i + 0.5) / side, 0.1 + 0.8 * (j + 0.5) / side});
    }
    return sites;
}

TEST(ErrorGrid, FindsNoErrorInALattice) {
    constexpr int kSide = 40;
    ErrorGrid grid({1, 1}, 0.8 / kSide, kSide * kSide, square(), Density::uniform());
    const auto sites = lattice(kSide);
    grid.measure(sites);
    for (const Point p : sites) {
        const bool inside = std::abs(p.x - 0.5) < 0.3 && std::abs(p.y - 0.5) < 0.3;
        EXPECT_NEAR(grid.at(p), 0, inside ? 1e-4 : 0.1) << p.x << ' ' << p.y;
    }
}

TEST(ErrorGrid, AssignsTheWholeError) {
    for (const Density& density : {Density::uniform(), test::grid_of(3, 2, [](int i, int j) { return 1.0 + i + j; })}) {
        std::vector<Point> sites;
        for (std::uint64_t i = 0; i < 900; ++i) {
            Random random(3, i);
            sites.push_back({0.1 + 0.8 * random.uniform(), 0.1 + 0.8 * random.uniform()});
        }
        ErrorGrid grid({1, 1}, 0.8 / 30, sites.size(), square(), density);
        grid.measure(sites);
        double sum = 0, squares = 0;
        for (const Point p : sites) {
            sum += grid.at(p);
            squares += grid.at(p) * grid.at(p);
        }
        EXPECT_NEAR(sum, 0, 1);
        EXPECT_GT(squares, 10) << "random sites are not even";
    }
}

TEST(ErrorGrid, LocatesASurplus) {
    constexpr int kSide = 40;
    auto sites = lattice(kSide);
    for (Point& p : sites) p.x = 0.1 + 0.8 * std::pow((p.x - 0.1) / 0.8, 1.2);
    ErrorGrid grid({1, 1}, 0.8 / kSide, sites.size(), square(), Density::uniform());
    grid.measure(sites);
    EXPECT_GT(grid.at({0.3, 0.5}), 0.02);
    EXPECT_LT(grid.at({0.8, 0.5}), -0.02);
}

/// A domain can be a thin line across its box, so the grid must not grow with the box.
TEST(ErrorGrid, StaysSmallInALargeBox) {
    const Point a{0, 0}, b{1, 0.999999}, c{1, 1}, d{0, 0.000001};
    const std::vector<BorderEdge> line{{a, b}, {b, c}, {c, d}, {d, a}};
    ErrorGrid grid({1, 1}, 1e-5, 1000, line, Density::uniform());
    std::vector<Point> sites;
    for (int i = 0; i < 1000; ++i) sites.push_back({(i + 0.5) / 1000, (i + 0.5) / 1000});
    grid.measure(sites);
    for (std::size_t i = 100; i < 900; ++i) EXPECT_NEAR(grid.at(sites[i]), 0, 1e-2) << i;
}

/// Each column has some points even where the box is far narrower than a cell, so the grid must not grow with length.
TEST(ErrorGrid, StaysSmallInALongBox) {
    const Point sides{1, 1e-15};
    const Point a{0, 0}, b{1, 0}, c{1, 1e-15}, d{0, 1e-15};
    const std::vector<BorderEdge> line{{a, b}, {b, c}, {c, d}, {d, a}};
    ErrorGrid grid(sides, 1e-12, 1000, line, Density::uniform());
    std::vector<Point> sites;  // 16 times as many as wanted, one per cell
    for (int i = 0; i < 16000; ++i) sites.push_back({(i + 0.5) / 16000, 5e-16});
    grid.measure(sites);
    for (std::size_t i = 100; i < 15900; ++i) EXPECT_NEAR(grid.at(sites[i]), 1 - 1.0 / 16, 1e-2) << i;
}

}  // namespace
}  // namespace ccdt
