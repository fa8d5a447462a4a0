// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/json_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/api/output/whole_body.h"

namespace ccdt::api {
namespace {

Distribution example() {
    Distribution distribution;
    distribution.points = {{0.1, 1e300}, {-0.0, 5e-324}, {1.0 / 3, 123456789.125}};
    distribution.iterations = 1;
    distribution.trace = {0.5, 0.25};
    return distribution;
}

std::string json_of(std::span<const InkDots> inks, const Report& report = {}) {
    return test::whole_body([&](Body& body) { write_json({inks}, report, body); });
}

/// Writes the dots of one ink without a name.
std::string json_of(const Distribution& dots, const Report& report = {}) {
    const Ink ink;
    const InkDots inks[] = {{ink, dots}};
    return json_of(inks, report);
}

std::string feature_of(const Distribution& dots, const Report& report = {}) {
    const Ink ink;
    const InkDots inks[] = {{ink, dots}};
    return test::whole_body([&](Body& body) { write_geojson({inks}, report, body); });
}

const Ink kCyan{"cyan", {0, 255, 255}}, kBlackInk{"black", kBlack};

TEST(JsonWriter, WritesEveryMember) {
    const auto json = nlohmann::json::parse(json_of(example(), {9007199254740991, 12.34567, {}}));
    EXPECT_EQ(json.at("sites"), 3);
    EXPECT_EQ(json.at("seed"), 9007199254740991);
    EXPECT_EQ(json.at("method"), "ccdt");
    EXPECT_EQ(json.at("iterations"), 1);
    EXPECT_EQ(json.at("variation"), 0.25);
    EXPECT_EQ(json.at("trace"),
              nlohmann::json::parse(R"([{"iteration":0,"variation":0.5},{"iteration":1,"variation":0.25}])"));
    EXPECT_EQ(json.at("elapsed_ms"), 12.346);
    EXPECT_EQ(json.size(), 8U);
}

TEST(JsonWriter, WritesEachInkSeparately) {
    const Distribution some = example();
    Distribution none;
    none.trace = {0};
    const std::vector<InkDots> inks = {{kCyan, some}, {kBlackInk, none}};
    const auto json = nlohmann::json::parse(json_of(inks, {7, 12.34567, PictureSize{30, 20}}));
    EXPECT_EQ(json.at("sites"), 3);
    EXPECT_EQ(json.at("seed"), 7);
    EXPECT_EQ(json.at("method"), "ccdt");
    EXPECT_EQ(json.at("elapsed_ms"), 12.346);
    EXPECT_EQ(json.at("width"), 30);
    EXPECT_EQ(json.at("height"), 20);
    EXPECT_EQ(json.size(), 7U);
    const auto plain = nlohmann::json::parse(json_of(some));
    const auto& cyan = json.at("inks").at(0);
    for (const auto* same : {"sites", "points", "trace", "iterations", "variation"})
        EXPECT_EQ(cyan.at(same), plain.at(same)) << same;
    EXPECT_EQ(cyan.at("name"), "cyan");
    EXPECT_EQ(cyan.at("color"), "#00ffff");
    const auto& black = json.at("inks").at(1);
    EXPECT_EQ(black.at("sites"), 0);
    EXPECT_EQ(black.at("points").size(), 0U);
    EXPECT_EQ(black.at("variation"), 0);
}

TEST(JsonWriter, MarksStoppedInksAsPartial) {
    const Distribution whole = example();
    Distribution stopped = whole;
    stopped.stopped = true;
    const std::vector<InkDots> inks = {{kCyan, whole}, {kBlackInk, stopped}};
    EXPECT_EQ(nlohmann::json::parse(json_of(inks)).at("partial"), true);
    EXPECT_FALSE(nlohmann::json::parse(json_of(std::span<const InkDots>(inks).first(1))).contains("partial"));
}

TEST(JsonWriter, WritesVariationOfPolishedPoints) {
    Distribution distribution = example();
    distribution.polished = 0.375;
    const auto json = nlohmann::json::parse(json_of(distribution));
    EXPECT_EQ(json.at("variation"), 0.375);
    EXPECT_EQ(json.at("trace").size(), 2U);
}

TEST(JsonWriter, WritesNumbersThatRoundTrip) {
    const Distribution distribution = example();
    const auto json = nlohmann::json::parse(json_of(distribution));
    const auto& points = json.at("points");
    ASSERT_EQ(points.size(), distribution.points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(points[i][0].get<double>(), distribution.points[i].x);
        EXPECT_EQ(points[i][1].get<double>(), distribution.points[i].y);
    }
}

TEST(JsonWriter, WritesShortestNumbers) {
    EXPECT_TRUE(json_of(example(), {}).starts_with("{\"points\":[[0.1,1e+300],"));
}

TEST(JsonWriter, RejectsNonFiniteNumbers) {
    for (const double none : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        Distribution distribution = example();
        distribution.trace.back() = none;
        EXPECT_THROW(json_of(distribution, {}), std::domain_error);
        EXPECT_THROW(feature_of(distribution), std::domain_error);
        distribution = example();
        distribution.points.back().y = none;
        EXPECT_THROW(json_of(distribution, {}), std::domain_error);
        Analysis analysis;
        analysis.power = {1, none};
        EXPECT_THROW(write_analysis(analysis, false), std::domain_error);
    }
}

TEST(JsonWriter, WritesMeshAndPictureSizeIfPresent) {
    Distribution distribution = example();
    distribution.mesh = TriangleMesh{{{0, 0}, {1, 0}, {0, 1}}, {{0, 1, 2}}, {{0, 1, 2}, {}}};
    const auto json = nlohmann::json::parse(json_of(distribution, {0, 0, PictureSize{640, 480}}));
    EXPECT_EQ(json.at("width"), 640);
    EXPECT_EQ(json.at("height"), 480);
    EXPECT_EQ(json.at("vertices").size(), 3U);
    EXPECT_EQ(json.at("triangles"), nlohmann::json::parse("[[0,1,2]]"));
    EXPECT_EQ(json.at("boundary"), nlohmann::json::parse("[[0,1,2],[]]"));
}

TEST(JsonWriter, WritesGeoJsonFeature) {
    const auto json = nlohmann::json::parse(feature_of(example(), {5, 12.3, {}, "odt"}));
    EXPECT_EQ(json.size(), 3U);
    EXPECT_EQ(json.at("type"), "Feature");
    EXPECT_EQ(json.at("geometry").size(), 2U);
    EXPECT_EQ(json.at("geometry").at("type"), "MultiPoint");
    EXPECT_EQ(json.at("geometry").at("coordinates"), nlohmann::json::parse(json_of(example())).at("points"));
    EXPECT_EQ(json.at("properties"),
              nlohmann::json::parse(R"({"sites":3,"seed":5,"method":"odt","iterations":1,"variation":0.25})"));
}

TEST(JsonWriter, EscapesNamesFromTheRequestInWarnings) {
    const std::string name = "/properties/a\"b\\\n\x01\xc3\xb6\xff";
    const Warning warnings[] = {{name, "has no \"such\" property"}};
    const std::string text = write_warnings(warnings);
    EXPECT_TRUE(std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; })) << text;
    const auto read = nlohmann::json::parse(text);
    EXPECT_EQ(read[0]["pointer"], "/properties/a\"b\\\n\x01\xc3\xb6\xef\xbf\xbd")
        << "a byte that is not UTF-8 is replaced";
    EXPECT_EQ(read[0]["detail"], "has no \"such\" property");
    Report report;
    report.warnings = warnings;
    EXPECT_EQ(nlohmann::json::parse(json_of(example(), report))["warnings"], read);
}

TEST(JsonWriter, MarksStoppedRunAsPartial) {
    Distribution distribution = example();
    distribution.stopped = true;
    EXPECT_TRUE(nlohmann::json::parse(feature_of(distribution)).at("properties").at("partial"));
    EXPECT_TRUE(nlohmann::json::parse(json_of(distribution)).at("partial"));
}

}  // namespace
}  // namespace ccdt::api
