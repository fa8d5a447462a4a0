// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/choice/choice_sample.h"

#include "api/sample/choice/choice_parser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ccdt::api {
namespace {

using Json = nlohmann::json;

/// @param members  members of the body in addition to 20 x 20 candidates on a grid
Result<ChoiceRequest> parse(const Json& members) {
    Json body = members;
    if (!body.contains("candidates")) {
        for (int i = 0; i < 400; ++i) body["candidates"].push_back({i % 20 + 0.25, i / 20});
    }
    const std::string text = body.dump();
    const auto document = JsonDocument::parse(text);
    EXPECT_TRUE(document);
    EXPECT_TRUE(asks_for_choice(document->root()));
    return parse_choice(document->root(), {}, "", {});
}

std::string answer(const Json& members) {
    const auto request = parse(members);
    if (!request) return request.error().field + ": " + request.error().message;
    Timings timings;
    const auto made = run_choice(*request, {}, {}, {}, timings);
    return made ? made->body : made.error().field + ": " + made.error().message;
}

std::string field(const Json& members) {
    const std::string text = answer(members);
    return text.substr(0, text.find(':'));
}

TEST(ChoiceSample, HasTheSameChoiceInAllFormats) {
    const Json list = Json::parse(answer({{"sites", 25}, {"seed", 3}}));
    ASSERT_EQ(list.at("indices").size(), 25U);
    std::string csv = "index,x,y\r\n";
    std::vector<std::uint32_t> rows;
    for (std::size_t i = 0; i < 25; ++i) {
        const int row = list.at("indices")[i];
        EXPECT_EQ(list.at("points")[i], Json({row % 20 + 0.25, row / 20}));
        rows.push_back(static_cast<std::uint32_t>(row));
        csv += std::to_string(row) + ',' + std::to_string(row % 20) + ".25," + std::to_string(row / 20) + "\r\n";
    }
    EXPECT_EQ(list.at("sites"), 25);
    EXPECT_EQ(list.at("shortfall"), 0);
    EXPECT_EQ(answer({{"sites", 25}, {"seed", 3}, {"format", "csv"}}), csv);
    const std::string npy = answer({{"sites", 25}, {"seed", 3}, {"format", "npy"}});
    EXPECT_EQ(npy.substr(npy.size() - 100), std::string(reinterpret_cast<const char*>(rows.data()), 100));
}

TEST(ChoiceSample, KeepsCandidatesAndFollowsTheDensity) {
    std::vector<int> density(400, 0);
    for (std::size_t i = 0; i < 200; ++i) density[i] = 1;
    const Json list = Json::parse(answer({{"sites", 30}, {"keep", {399, 7}}, {"density", density}}));
    const auto rows = list.at("indices").get<std::vector<int>>();
    ASSERT_EQ(rows.size(), 30U);
    EXPECT_EQ(rows.back(), 399);
    EXPECT_LT(rows[28], 200);
    EXPECT_NE(std::ranges::find(rows, 7), rows.end());
}

TEST(ChoiceSample, FollowsAMapOfDensities) {
    const Json map = {{"width", 2}, {"height", 1}, {"values", {0, 1}}};
    for (const Json& point : Json::parse(answer({{"sites", 50}, {"density", map}})).at("points"))
        EXPECT_GE(point[0].get<double>(), 9.75);
}

TEST(ChoiceSample, TakesOtherKindsOfCandidates) {
    const Json geojson = {{"type", "MultiPoint"}, {"coordinates", {{179.9, 0}, {-179.9, 0}, {0, 0}, {90, 0}}}};
    EXPECT_EQ(Json::parse(answer({{"sites", 3}, {"candidates", geojson}, {"coordinates", "lonlat"}})).at("sites"), 3);
    const Json space = {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
    for (const char* domain : {"surface", "solid"}) {
        const Json body = {{"sites", 2}, {"candidates", space}, {"domain", domain}, {"format", "csv"}};
        EXPECT_EQ(answer(body).substr(0, 11), "index,x,y,z");
    }
    EXPECT_EQ(Json::parse(answer({{"sites", 0}, {"candidates", Json::array()}})).at("indices"), Json::array());
}

TEST(ChoiceSample, NamesTheFaultyField) {
    EXPECT_EQ(field({{"seed", 1}}), "/sites");
    EXPECT_EQ(field({{"sites", 401}}), "/sites");
    EXPECT_EQ(field({{"sites", 4}, {"keep", {400}}}), "/keep/0");
    EXPECT_EQ(field({{"sites", 1}, {"keep", {4, 5}}}), "/keep");
    EXPECT_EQ(field({{"sites", 4}, {"density", {1, 2}}}), "/density");
    EXPECT_EQ(field({{"sites", 4}, {"density", {1, -2}}}), "/density/1");
    EXPECT_EQ(field({{"sites", 4}, {"priority", {1, 2}}}), "/priority");
    EXPECT_EQ(field({{"sites", 4}, {"domain", "solid"}}), "/domain");
    EXPECT_EQ(field({{"sites", 1}, {"coordinates", "lonlat"}, {"candidates", {{0, 91}, {0, 0}}}}), "/candidates/0");
    EXPECT_EQ(field({{"sites", 1}, {"candidates", {{0, 1}, {0, "a"}}}}), "/candidates/1");
    EXPECT_EQ(field({{"sites", 1}, {"iterations", 1}}), "/iterations");
}

}  // namespace
}  // namespace ccdt::api
