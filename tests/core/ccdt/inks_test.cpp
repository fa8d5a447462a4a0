#include "core/ccdt/inks.h"

#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/meshes.h"
#include "tests/support/pictures.h"

namespace ccdt {
namespace {

using test::grid_of;

const Domain kSquare = Domain::rectangle(1, 1).value();

bool same_bytes(const std::vector<Point>& a, const std::vector<Point>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Point)) == 0;
}

/// Three inks, each dense where another one is not.
std::vector<Density> ramps() {
    const auto ramp = [](double x, double y) {
        return grid_of(64, 64, [=](int i, int j) { return 0.2 + x * i / 64 + y * j / 64; });
    };
    return {ramp(1, 0), ramp(-0.1, 0.8), ramp(0, 0)};
}

TEST(DistributeInks, GivesEachInkItsSitesInside) {
    const std::vector<std::size_t> counts{500, 0, 1};
    const auto inks = distribute_inks(kSquare, ramps(), counts, {.seed = 3}).value();
    ASSERT_EQ(inks.size(), counts.size());
    for (std::size_t i = 0; i < inks.size(); ++i) {
        EXPECT_EQ(inks[i].points.size(), counts[i]);
        for (const Point& p : inks[i].points) EXPECT_TRUE(p.x > 0 && p.x < 1 && p.y > 0 && p.y < 1);
        EXPECT_TRUE(std::isfinite(inks[i].variation()));
    }
}

TEST(DistributeInks, GivesOneInkTheDotsOfGrey) {
    const std::vector<Density> densities = ramps();
    for (const Quality quality : {Quality::Draft, Quality::Standard, Quality::Best}) {
        Options options{.seed = 5, .quality = quality};
        const auto inks = distribute_inks(kSquare, densities, std::vector<std::size_t>{0, 400, 0}, options).value();
        options.sites = 400;
        const auto grey = distribute(kSquare, densities[1], options).value();
        EXPECT_TRUE(same_bytes(inks[1].points, grey.points));
        EXPECT_EQ(inks[1].trace, grey.trace);
        EXPECT_EQ(inks[1].polished, grey.polished);
        EXPECT_EQ(inks[1].iterations, grey.iterations);
    }
}

TEST(DistributeInks, TellsOfAllInksAsOneRun) {
    std::vector<Progress> told;
    const Control control{{}, [&](const Progress& progress) { told.push_back(progress); }};
    const Options options{.iterations = 3};
    const auto inks =
        distribute_inks(kSquare, ramps(), std::vector<std::size_t>{300, 200, 100}, options, control).value();
    ASSERT_EQ(told.size(), 4u);
    for (std::size_t i = 0; i < told.size(); ++i) {
        EXPECT_EQ(told[i].iteration, static_cast<int>(i));
        EXPECT_EQ(told[i].iterations, 3);
        double largest = 0;
        for (const Distribution& ink : inks) largest = std::max(largest, ink.trace[i]);
        EXPECT_EQ(told[i].variation, largest);
    }
}

TEST(DistributeInks, ReturnsAllInksAsTheyStandWhenStopped) {
    std::stop_source source;
    const Control control{source.get_token(), [&](const Progress& progress) {
                              if (progress.iteration == 2) source.request_stop();
                          }};
    const std::vector<std::size_t> counts{300, 200, 100};
    const auto inks = distribute_inks(kSquare, ramps(), counts, {}, control).value();
    for (std::size_t i = 0; i < inks.size(); ++i) {
        EXPECT_TRUE(inks[i].stopped);
        EXPECT_EQ(inks[i].iterations, 2);
        EXPECT_EQ(inks[i].points.size(), counts[i]);
    }
}

TEST(DistributeInks, FailsIfStoppedDuringTheStart) {
    std::stop_source source;
    source.request_stop();
    const auto inks =
        distribute_inks(kSquare, ramps(), std::vector<std::size_t>{300, 200, 100}, {}, {source.get_token(), {}});
    ASSERT_FALSE(inks);
    EXPECT_EQ(inks.error().code, ErrorCode::Stopped);
}

TEST(DistributeInks, RefusesWhatDistributeRefuses) {
    const std::vector<Density> densities = ramps();
    const auto none = distribute_inks(kSquare, densities, std::vector<std::size_t>{0, 0, 0}, {});
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().field, "sites");
    const auto passes = distribute_inks(kSquare, densities, std::vector<std::size_t>{9, 9, 9}, {.passes = 0});
    ASSERT_FALSE(passes);
    EXPECT_EQ(passes.error().field, "passes");
}

}  // namespace
}  // namespace ccdt
