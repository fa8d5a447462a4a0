// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/delaunay.h"

#include <stop_token>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

TEST(ConstrainedDelaunay, DoesNothingAfterAStop) {
    constexpr std::size_t kPoints = 10'000;
    Random random(1, 0);
    std::vector<Point> points;
    for (std::size_t i = 0; i < kPoints; ++i) points.push_back({random.uniform(), random.uniform()});
    std::stop_source stop;
    const auto whole = constrained_delaunay(points, {}, stop.get_token());
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->triangles.size(), 2 * kPoints + 2) << "a box with points inside";
    stop.request_stop();
    const auto stopped = constrained_delaunay(points, {}, stop.get_token());
    ASSERT_TRUE(stopped);
    EXPECT_TRUE(stopped->triangles.empty());
}

}  // namespace
}  // namespace ccdt
