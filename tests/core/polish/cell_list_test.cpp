// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/polish/cell_list.h"

#include <set>

#include <gtest/gtest.h>

#include "core/random.h"

namespace ccdt {
namespace {

/// Returns points of which most are crowded at two positions, at different scales; the others are anywhere.
std::vector<Point> crowds(std::size_t count) {
    Random random(6, 0);
    std::vector<Point> places;
    for (std::size_t i = 0; i < count; ++i) {
        const Point at{random.uniform(), random.uniform()};
        places.push_back(i % 8 == 0 ? at : i % 8 == 1 ? Point{0.999, 0.5} + 1e-3 * at : Point{0.3, 0.7} + 1e-6 * at);
    }
    return places;
}

/// Returns the distance between two points; on a torus, between their nearest copies.
double distance(const Domain& domain, Point a, Point b) {
    Point apart = a - b;
    if (domain.is_torus()) apart = {apart.x - std::round(apart.x), apart.y - std::round(apart.y)};
    return std::sqrt(dot(apart, apart));
}

TEST(CellList, FindsAllPointsNearby) {
    const std::vector<Point> places = crowds(2000);
    for (const Domain& domain : {Domain::rectangle(1, 1).value(), Domain::torus(1, 1).value()}) {
        const CellList cells(domain, places);
        for (const double reach : {1e-8, 1e-5, 0.01, 0.3}) {
            for (std::size_t i = 0; i < places.size(); i += 7) {
                std::set<std::uint32_t> found, expected;
                cells.for_near(places[i], reach, [&](Point place, std::uint32_t number) {
                    const Point apart = places[i] - place;
                    if (dot(apart, apart) >= reach * reach) return;
                    EXPECT_TRUE(found.insert(number).second) << "visited twice";
                });
                for (std::uint32_t k = 0; k < places.size(); ++k) {
                    if (distance(domain, places[i], places[k]) < reach) expected.insert(k);
                }
                ASSERT_EQ(found, expected) << domain.is_torus() << ' ' << reach << ' ' << i;
            }
        }
    }
}

TEST(CellList, VisitsFewPointsInCrowds) {
    const std::vector<Point> places = crowds(80'000);
    const CellList cells(Domain::rectangle(1, 1).value(), places);
    for (std::size_t i = 2; i < places.size(); i += 101) {
        if (i % 8 < 2) continue;
        int visited = 0;
        cells.for_near(places[i], 4e-9, [&](Point, std::uint32_t) { ++visited; });
        ASSERT_LT(visited, 200) << "of the 60,000 points in a crowd, at mean distances of 4e-9";
    }
}

TEST(CellList, AcceptsManyCoincidentPoints) {
    for (const std::size_t many : {100, 100'000}) {
        const std::vector<Point> places(many, Point{0.7, 0.3});
        std::size_t found = 0;
        CellList(Domain::rectangle(3, 2).value(), places).for_near({0.7, 0.3}, 1e-3, [&](Point, std::uint32_t) {
            ++found;
        });
        EXPECT_EQ(found, many);
    }
}

}  // namespace
}  // namespace ccdt
