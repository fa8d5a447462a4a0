// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/cell_list.h"

#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

/// Returns points of which most are crowded at two positions, at different scales; the others are anywhere.
std::vector<Point> crowds(std::size_t count) {
    Random random(6, 0);
    std::vector<Point> positions;
    for (std::size_t i = 0; i < count; ++i) {
        const Point at{random.uniform(), random.uniform()};
        positions.push_back(i % 8 == 0 ? at : i % 8 == 1 ? Point{0.999, 0.5} + 1e-3 * at : Point{0.3, 0.7} + 1e-6 * at);
    }
    return positions;
}

/// Returns the distance between two points; on a torus, between their nearest copies.
double distance(const Domain& domain, Point a, Point b) {
    Point apart = a - b;
    if (domain.is_torus()) apart = {apart.x - std::round(apart.x), apart.y - std::round(apart.y)};
    return std::sqrt(dot(apart, apart));
}

TEST(CellList, FindsAllPointsNearby) {
    const std::vector<Point> positions = crowds(2000);
    for (const Domain& domain : {Domain::rectangle(1, 1).value(), Domain::torus(1, 1).value()}) {
        const CellList cells(domain, positions);
        for (const double reach : {1e-8, 1e-5, 0.01, 0.3}) {
            for (std::size_t i = 0; i < positions.size(); i += 7) {
                std::set<std::uint32_t> found, expected;
                cells.for_near(positions[i], reach, [&](Point position, std::uint32_t number) {
                    const Point apart = positions[i] - position;
                    if (dot(apart, apart) >= reach * reach) return;
                    EXPECT_TRUE(found.insert(number).second) << "visited twice";
                });
                for (std::uint32_t k = 0; k < positions.size(); ++k) {
                    if (distance(domain, positions[i], positions[k]) < reach) expected.insert(k);
                }
                ASSERT_EQ(found, expected) << domain.is_torus() << ' ' << reach << ' ' << i;
            }
        }
    }
}

TEST(CellList, VisitsFewPointsInCrowds) {
    const std::vector<Point> positions = crowds(80'000);
    const CellList cells(Domain::rectangle(1, 1).value(), positions);
    for (std::size_t i = 2; i < positions.size(); i += 101) {
        if (i % 8 < 2) continue;
        int visited = 0;
        cells.for_near(positions[i], 4e-9, [&](Point, std::uint32_t) { ++visited; });
        ASSERT_LT(visited, 200) << "of the 60,000 points in a crowd, at mean distances of 4e-9";
    }
}

TEST(CellList, AcceptsManyCoincidentPoints) {
    for (const std::size_t many : {100, 100'000}) {
        const std::vector<Point> positions(many, Point{0.7, 0.3});
        std::size_t found = 0;
        CellList(Domain::rectangle(3, 2).value(), positions).for_near({0.7, 0.3}, 1e-3, [&](Point, std::uint32_t) {
            ++found;
        });
        EXPECT_EQ(found, many);
    }
}

/// Returns points on a sphere of radius 0.4 around (1, 2, 3), of which most are crowded near one point.
std::vector<Point3> sphere(std::size_t count) {
    Random random(7, 0);
    std::vector<Point3> positions;
    while (positions.size() < count) {
        const double spread = positions.size() % 4 == 0 ? 1 : 1e-3;
        const double z = 1 - 2 * spread * random.uniform(), angle = 2 * std::numbers::pi * random.uniform();
        const double radius = std::sqrt(1 - z * z);
        positions.push_back(Point3{1, 2, 3} + 0.4 * Point3{radius * std::cos(angle), radius * std::sin(angle), z});
    }
    return positions;
}

/// Returns points on a square at a constant x.
std::vector<Point3> wall(std::size_t count) {
    Random random(8, 0);
    std::vector<Point3> positions;
    while (positions.size() < count) positions.push_back({0.1, random.uniform(), random.uniform()});
    return positions;
}

TEST(CellList3, FindsAllPointsNearby) {
    for (const std::vector<Point3>& positions : {sphere(3000), wall(3000)}) {
        const CellList3 cells(positions);
        const std::vector<std::uint32_t> numbers = cells.numbers();
        std::vector<CellList3::Run> runs;
        for (const double reach : {1e-4, 0.01, 0.3}) {
            for (std::size_t i = 0; i < positions.size(); i += 13) {
                std::set<std::uint32_t> found, in_runs, expected;
                cells.for_near(positions[i], reach, [&](Point3 position, std::uint32_t number) {
                    EXPECT_EQ(position, positions[number]);
                    if (length(positions[i] - position) >= reach) return;
                    EXPECT_TRUE(found.insert(number).second) << "visited twice";
                });
                cells.find_near(positions[i], reach, runs);
                for (const auto [begin, end] : runs) {
                    for (std::uint32_t k = begin; k < end; ++k) {
                        if (length(positions[i] - positions[numbers[k]]) < reach) in_runs.insert(numbers[k]);
                    }
                }
                for (std::uint32_t k = 0; k < positions.size(); ++k) {
                    if (length(positions[i] - positions[k]) < reach) expected.insert(k);
                }
                ASSERT_EQ(found, expected) << reach << ' ' << i;
                ASSERT_EQ(in_runs, expected) << reach << ' ' << i;
            }
        }
    }
}

TEST(CellList3, VisitsFewPointsOfSurfaces) {
    for (const std::vector<Point3>& positions : {sphere(100'000), wall(100'000)}) {
        const CellList3 cells(positions);
        std::size_t visited = 0, queries = 0;
        for (std::size_t i = 0; i < positions.size(); i += 101, ++queries)
            cells.for_near(positions[i], 1e-5, [&](Point3, std::uint32_t) { ++visited; });
        EXPECT_LT(visited, 40 * queries);
    }
}

TEST(CellList3, AcceptsCoincidentAndCollinearPoints) {
    std::vector<Point3> positions(1'000, Point3{0.7, 0.3, -5});
    const auto count = [&](double reach) {
        std::size_t found = 0;
        CellList3(positions).for_near({0.7, 0.3, -5}, reach, [&](Point3, std::uint32_t) { ++found; });
        return found;
    };
    EXPECT_EQ(count(1e-3), 1'000);
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i].z += static_cast<double>(i);
    EXPECT_LT(count(1.5), 5);
    positions.resize(1);
    EXPECT_EQ(count(1e-3), 1);
}

}  // namespace
}  // namespace ccdt
