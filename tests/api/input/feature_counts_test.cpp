// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/feature_counts.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "api/json/json_document.h"

namespace ccdt::api {
namespace {

/// Counts features that lie beside each other on a line, except for those that have no place.
Result<FeatureCounts> count(const std::string& features, const Counting& counting, const Limits& limits = {},
                            std::size_t without_place = 0) {
    const auto document = JsonDocument::parse(R"({"type":"FeatureCollection","features":[)" + features + "]}");
    EXPECT_TRUE(document) << document.error().message;
    const FeatureSource source = *find_features({"/geometry", "/geometry", document->root()});
    std::vector<std::optional<Point3>> positions(source.features.size());
    for (std::size_t i = without_place; i < positions.size(); ++i) positions[i] = {static_cast<double>(i), 0, 0};
    return count_features(source, positions, counting, limits, "/sites");
}

std::string feature(const std::string& properties, const std::string& more = "") {
    return R"({"type":"Feature","geometry":null,"properties":)" + properties + more + '}';
}

Counting people(double per) {
    Counting counting;
    counting.property = "people";
    counting.per = per;
    return counting;
}

TEST(FeatureCounts, RoundsUpOrDownToTheRoundedSum) {
    const auto counts = count(feature(R"({"people":260})") + ',' + feature(R"({"people":170})") + ',' +
                                  feature(R"({"people":70})") + ',' + feature(R"({"people":0})"),
                              people(100));
    ASSERT_TRUE(counts) << counts.error().message;
    EXPECT_EQ(counts->total(), 5U);
    EXPECT_EQ(counts->counts[0] / 2, 1U);
    EXPECT_EQ(counts->counts[3], 0U);
}

TEST(FeatureCounts, RoundsFeaturesWithoutPlaceByThemselves) {
    std::string features = feature(R"({"people":40})");
    for (int i = 0; i < 4; ++i) features += ',' + feature(R"({"people":40})");
    EXPECT_EQ(count(features, people(100), {}, 5).error().code, ErrorCode::Unusable);
    const auto counts = count(features + ',' + feature(R"({"people":60})"), people(100), {}, 2);
    ASSERT_TRUE(counts) << counts.error().message;
    EXPECT_EQ(counts->counts[0] + counts->counts[1], 0U);
    EXPECT_EQ(counts->total(), 2U);
}

TEST(FeatureCounts, ReadsNumbersInStrings) {
    const auto counts = count(feature(R"({"people":" 1200 "})") + ',' + feature(R"({"people":8e2})"), people(100));
    ASSERT_TRUE(counts) << counts.error().message;
    EXPECT_EQ(counts->counts, (std::vector<std::size_t>{12, 8}));
}

TEST(FeatureCounts, CountsMissingPropertiesAsZero) {
    const auto counts = count(
        feature("{}") + ',' + feature("null") + ',' + feature(R"({"people":null})") + ',' + feature(R"({"people":3})"),
        people(1));
    ASSERT_TRUE(counts) << counts.error().message;
    EXPECT_EQ(counts->counts, (std::vector<std::size_t>{0, 0, 0, 3}));
    EXPECT_EQ(counts->missing.front().features, 3U);
    EXPECT_EQ(counts->missing.front().first, "/geometry/features/0/properties/people");
}

TEST(FeatureCounts, CountsEachClass) {
    Counting counting;
    counting.per = 10;
    counting.classes = {"a", "b"};
    const auto counts = count(feature(R"({"a":20,"b":5})") + ',' + feature(R"({"a":0,"b":25})"), counting);
    ASSERT_TRUE(counts) << counts.error().message;
    EXPECT_EQ(counts->points_of(0) + counts->points_of(1), 5U);
    EXPECT_EQ(counts->count(0, 0), 2U);
    EXPECT_EQ(counts->count(1, 0), 0U);
    EXPECT_EQ(counts->count(0, 1) + counts->count(1, 1), 3U);
    EXPECT_TRUE(counts->are_named);
}

TEST(FeatureCounts, RefusesInvalidCounts) {
    for (const std::string value : {"-1", "\"-1\"", "\"many\"", "\"\"", "\"1,000\"", "true", "[1]", "\"inf\""}) {
        const auto counts = count(feature(R"({"people":1})") + ',' + feature(R"({"people":)" + value + '}'), people(1));
        ASSERT_FALSE(counts) << value;
        EXPECT_EQ(counts.error().code, ErrorCode::Malformed);
        EXPECT_EQ(counts.error().field, "/geometry/features/1/properties/people") << value;
    }
}

TEST(FeatureCounts, RefusesPropertiesThatAreNotAnObject) {
    for (const std::string properties : {"[1]", "1", "\"people\"", "true"}) {
        const auto counts = count(feature(R"({"people":1})") + ',' + feature(properties), people(1));
        ASSERT_FALSE(counts) << properties;
        EXPECT_EQ(counts.error().code, ErrorCode::Malformed);
        EXPECT_EQ(counts.error().field, "/geometry/features/1/properties") << properties;
    }
}

TEST(FeatureCounts, RefusesTooManyPointsAndNone) {
    const std::string features = feature(R"({"people":1e300})") + ',' + feature(R"({"people":1e308})");
    const auto many = count(features, people(1));
    ASSERT_FALSE(many);
    EXPECT_EQ(many.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(many.error().field, "/sites");
    EXPECT_EQ(count(features, people(1e-300)).error().code, ErrorCode::LimitExceeded);
    const auto none = count(features, people(1.7e308));
    ASSERT_TRUE(none) << none.error().message;
    EXPECT_EQ(none->total(), 1U);
    EXPECT_EQ(count(feature(R"({"people":1})"), people(1000)).error().code, ErrorCode::Unusable);
    Limits few;
    few.max_sites = 10;
    EXPECT_TRUE(count(feature(R"({"people":10})"), people(1), few));
    EXPECT_EQ(count(feature(R"({"people":11})"), people(1), few).error().code, ErrorCode::LimitExceeded);
}

}  // namespace
}  // namespace ccdt::api
