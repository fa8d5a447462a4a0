// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/analyze/surface_analyze.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace ccdt::api {
namespace {

/// Decodes any file as the unit square at z = 5.
Decode square() {
    Decode decode;
    decode.surface = [](std::string_view, const SurfaceHeader&, const std::stop_token&) -> Result<SurfaceContents> {
        return SurfaceContents{
            {.vertices = {{0, 0, 5}, {1, 0, 5}, {1, 1, 5}, {0, 1, 5}}, .triangles = {{0, 1, 2}, {0, 2, 3}}}};
    };
    return decode;
}

SurfaceFile file_of(std::uint64_t triangles) {
    return {"", {SurfaceFormat::Obj, triangles, 3 * triangles, 1'000}};
}

Result<SurfaceAnalyzeRequest> parse(const std::vector<TextOption>& options, std::string_view accept = "",
                                    const Limits& limits = {}) {
    return parse_surface_analyze(file_of(2), options, accept, limits);
}

Result<Answer> answer(const SurfaceAnalyzeRequest& request, const Control& control = {}) {
    Timings timings;
    return run_surface_analyze(request, square(), control, timings);
}

TEST(SurfaceAnalyzeRequest, ReadsEveryOption) {
    const auto request = parse({{"points", "[[1,2,3],[4,5,6]]"}, {"modes", "7"}});
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->points, (std::vector<Point3>{{1, 2, 3}, {4, 5, 6}}));
    EXPECT_EQ(request->modes, 7U);
    EXPECT_EQ(parse({{"points", "x,y,z\n1,2,3\n4,5,6\n"}})->modes, 100U);
    EXPECT_EQ(size_of(*request), 2 * sizeof(Point3));
}

TEST(SurfaceAnalyzeRequest, LocatesErrorsByTheNameOfTheOption) {
    const std::pair<std::vector<TextOption>, std::string_view> cases[] = {
        {{}, "points"},
        {{{"modes", "5"}}, "points"},
        {{{"points", "[[1,2]]"}}, "points"},
        {{{"points", "[[1,2,3]]"}, {"modes", "0"}}, "modes"},
        {{{"points", "[[1,2,3]]"}, {"modes", "501"}}, "modes"},
        {{{"points", "[[1,2,3]]"}, {"points", "[[1,2,3]]"}}, "points"},
        {{{"points", "[[1,2,3]]"}, {"domain", "{}"}}, "domain"},
        {{{"points", "[[1,2,3]]"}, {"format", "png"}}, "format"},
    };
    for (const auto& [options, field] : cases) {
        const auto request = parse(options);
        ASSERT_FALSE(request) << field;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed);
        EXPECT_EQ(request.error().field, field);
    }
    EXPECT_EQ(parse({{"points", "[[1,2,3],[4,5,6]]"}}, "image/png").error().code, ErrorCode::NotAcceptable);
    EXPECT_TRUE(parse({{"points", "[[1,2,3],[4,5,6]]"}, {"format", "json"}}, "image/png"));
    EXPECT_EQ(parse({{"points", "[[1,2]]"}}).error().message, "points/0 must be a position [x, y, z]");
    Limits one;
    one.max_sites = 1;
    EXPECT_EQ(parse({{"points", "[[1,2,3],[1,2,3]]"}}, "", one).error().code, ErrorCode::LimitExceeded);
    const auto damaged =
        parse_surface_analyze(failure(ErrorCode::Unusable, "damaged"), {{"points", "[[1,2,3],[4,5,6]]"}}, "", {});
    EXPECT_EQ(damaged.error().message, "damaged");
}

TEST(SurfaceAnalyzeAnswer, HasTheDistancesAndThePowerOfEachMode) {
    const auto found = answer({file_of(2), {{0.25, 0.25, 5}, {0.75, 0.25, 5}, {0.25, 0.75, 5}, {0.75, 0.75, 6}}, 3});
    ASSERT_TRUE(found) << found.error().message;
    const auto json = nlohmann::json::parse(found->body);
    EXPECT_EQ(json.at("eigenvalues").size(), 3U);
    EXPECT_EQ(json.at("power").size(), 3U);
    // The last point is projected to the square, so that the four points are a lattice.
    const double hexagonal = std::sqrt(2 / (std::sqrt(3.0) * 4));
    EXPECT_NEAR(json.at("min_distance").get<double>(), 0.5 / hexagonal, 1e-9);
    EXPECT_NEAR(json.at("mean_distance").get<double>(), 0.5 / hexagonal, 1e-9);
    EXPECT_NEAR(json.at("frequency")[0].get<double>(), 0.25, 0.02);
    EXPECT_NEAR(json.at("low_frequency_power").get<double>(), 0, 0.01);
}

TEST(SurfaceAnalyzeRequest, RefusesASinglePoint) {
    const auto single = parse({{"points", "[[0.25,0.25,5]]"}});
    ASSERT_FALSE(single);
    EXPECT_EQ(single.error().code, ErrorCode::Unusable);
    EXPECT_EQ(single.error().field, "points");
}

TEST(SurfaceAnalyzeAnswer, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    Control control;
    control.stop = source.get_token();
    EXPECT_EQ(answer({file_of(2), {{0, 0, 5}, {1, 1, 5}}, 1}, control).error().code, ErrorCode::Stopped);
}

TEST(SurfaceAnalyzeCost, GrowsWithTheMeshAndTheModes) {
    const auto cost = [](std::uint64_t triangles, std::size_t modes) {
        return cost_of(SurfaceAnalyzeRequest{file_of(triangles), {{0, 0, 0}}, modes});
    };
    EXPECT_GT(cost(200'000, 100).memory, cost(20'000, 100).memory);
    EXPECT_GT(cost(20'000, 400).memory, cost(20'000, 100).memory);
    EXPECT_GT(cost(20'000, 400).seconds, 4 * cost(20'000, 100).seconds);
}

}  // namespace
}  // namespace ccdt::api
