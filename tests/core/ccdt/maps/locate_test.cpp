// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/locate.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/ccdt/globe/turns.h"
#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;

std::vector<std::uint32_t> located(const std::vector<test::Parts>& areas, const std::vector<Point>& points,
                                   double period = 0) {
    std::vector<Domain> domains;
    for (const test::Parts& parts : areas) domains.push_back(Domain::repair(parts).value().domain);
    std::vector<const Domain*> pointers;
    for (const Domain& domain : domains) pointers.push_back(&domain);
    return locate(pointers, points, period).value();
}

using Indices = std::vector<std::uint32_t>;

TEST(Locate, FindsTheAreaOfEachPoint) {
    const std::vector<test::Parts> areas = {{{box(5, 5, 1, 1), {}}},
                                            {{box(6, 5, 1, 1), {}}, {box(9, 9, 1, 1), {}}},
                                            {{box(4, 4, 4, 4), {box(5, 5, 2, 1)}}}};
    EXPECT_EQ(located(areas, {{5.5, 5.5}, {6.5, 5.5}, {9.5, 9.5}, {4.5, 5.5}, {7.5, 5.5}}), (Indices{0, 1, 1, 2, 2}));
}

TEST(Locate, ChoosesTheFirstOfOverlappingAreas) {
    const test::Parts left = {{box(0, 0, 2, 1), {}}}, right = {{box(1, 0, 2, 1), {}}};
    EXPECT_EQ(located({left, right}, {{0.5, 0.5}, {1.5, 0.5}, {2.5, 0.5}}), (Indices{0, 0, 1}));
    EXPECT_EQ(located({right, left}, {{0.5, 0.5}, {1.5, 0.5}, {2.5, 0.5}}), (Indices{1, 0, 0}));
}

TEST(Locate, ChoosesTheNearestAreaForPointsOutside) {
    const std::vector<test::Parts> areas = {{{box(0, 0, 1, 1), {}}}, {{box(1, 0, 1, 1), {}}}, {{box(3, 0, 1, 1), {}}}};
    EXPECT_EQ(located(areas, {{1, 0.5}, {2.9, 0.5}, {2.1, 0.5}, {-5, 0}, {90, 90}}), (Indices{0, 2, 1, 0, 2}));
}

TEST(Locate, ReturnsTheOnlyAreaWithoutASearch) {
    EXPECT_EQ(located({{{box(0, 0, 1, 1), {}}}}, {{0.5, 0.5}, {7, 7}}), (Indices{0, 0}));
}

TEST(Locate, FindsPointsAtEquivalentLongitudes) {
    const std::vector<test::Parts> areas = {{{box(170, 0, 30, 10), {}}}, {{box(-540, 0, 10, 10), {}}}};
    EXPECT_EQ(located(areas, {{175, 5}, {-165, 5}, {-175, 5}}, kTurn), (Indices{0, 0, 0}));
    EXPECT_EQ(located({areas[1], areas[0]}, {{175, 5}, {-165, 5}, {-175, 5}}, kTurn), (Indices{1, 1, 0}));
}

TEST(Locate, FindsPointsOfAnyMagnitude) {
    for (const double size : {1e-139, 1e-9, 1e9, 1e139}) {
        const std::vector<test::Parts> areas = {{{box(0, 0, size, size), {}}}, {{box(size, 0, size, size), {}}}};
        EXPECT_EQ(located(areas, {{0.5 * size, 0.5 * size}, {1.5 * size, 0.5 * size}, {size, 0.5 * size}}),
                  (Indices{0, 1, 0}))
            << size;
    }
}

TEST(Locate, StopsOnRequest) {
    const Domain area = Domain::rectangle(1, 1).value();
    const std::vector<const Domain*> areas = {&area, &area};
    const std::vector<Point> points = {{0.5, 0.5}};
    std::stop_source source;
    source.request_stop();
    EXPECT_EQ(locate(areas, points, 0, source.get_token()).error().code, ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt
