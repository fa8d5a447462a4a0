// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "api/sample/plane/sample_cost.h"
#include "api/sample/plane/sample_parser.h"

namespace ccdt::api {
namespace {

using Json = nlohmann::json;

/// Returns a feature: the square with this number in a row of squares of side 2.
std::string square(int number, const std::string& properties, const std::string& more = "") {
    const std::string west = std::to_string(2 * number), east = std::to_string(2 * number + 2);
    return R"({"type":"Feature",)" + more + R"("properties":)" + properties +
           R"(,"geometry":{"type":"Polygon","coordinates":[[[)" + west + ",0],[" + east + ",0],[" + east + ",2],[" +
           west + ",2],[" + west + ",0]]]}}";
}

std::string collection(const std::string& features) {
    return R"({"type":"FeatureCollection","features":[)" + features + "]}";
}

const std::string kThree =
    collection(square(0, R"({"name":"a, \"b\"","n":1.5,"tags":{"k":[1,null]}})", R"("id":"w",)") + ',' +
               square(1, R"({"name":"line\nbreak","n":null,"x":true})") + ',' + square(2, "null"));

Result<Answer> answer(const std::string& body, const std::vector<TextOption>& options = {}) {
    const auto request = parse_sample(body, options, "", {});
    if (!request) return tl::make_unexpected(request.error());
    Timings timings;
    return run_sample(*request, {}, decode_inline(), {}, timings);
}

std::string body_of(const std::string& geometry, std::vector<TextOption> options) {
    const auto result = answer(geometry, options);
    EXPECT_TRUE(result) << result.error().message;
    return result ? result->body : "";
}

Error error_of(const std::string& body, const std::vector<TextOption>& options) {
    const auto result = answer(body, options);
    EXPECT_FALSE(result);
    return result ? Error() : result.error();
}

std::vector<std::vector<double>> sorted(std::vector<std::vector<double>> points) {
    std::ranges::sort(points);
    return points;
}

std::vector<std::vector<double>> points_of(const std::string& geometry, std::vector<TextOption> options) {
    options.push_back({"format", "json"});
    return Json::parse(body_of(geometry, options)).at("points").get<std::vector<std::vector<double>>>();
}

TEST(Properties, AreThoseOfTheContainingFeature) {
    const auto json = Json::parse(body_of(kThree, {{"sites", "60"}, {"properties", "name,n"}, {"format", "geojson"}}));
    EXPECT_EQ(json.at("type"), "FeatureCollection");
    EXPECT_EQ(json.at("sites"), 60);
    const Json& features = json.at("features");
    ASSERT_EQ(features.size(), 3U);
    EXPECT_EQ(features[0].at("id"), "w");
    EXPECT_EQ(features[0].at("properties").at("name"), "a, \"b\"");
    EXPECT_EQ(features[0].at("properties").at("n"), 1.5);
    EXPECT_TRUE(features[1].at("properties").at("n").is_null());
    EXPECT_FALSE(features[2].at("properties").contains("name"));
    std::size_t points = 0;
    for (std::size_t i = 0; i < features.size(); ++i) {
        EXPECT_EQ(features[i].at("properties").at("feature"), i);
        for (const Json& point : features[i].at("geometry").at("coordinates")) {
            EXPECT_EQ(static_cast<std::size_t>(point.at(0).get<double>() / 2), i);
            ++points;
        }
    }
    EXPECT_EQ(points, 60U);
}

TEST(Properties, DoNotMovePoints) {
    for (const std::string coordinates : {"plane", "lonlat"}) {
        const std::vector<TextOption> plain = {{"sites", "50"}, {"coordinates", coordinates}};
        auto carrying = plain;
        carrying.push_back({"properties", "*"});
        EXPECT_EQ(sorted(points_of(kThree, plain)), sorted(points_of(kThree, carrying))) << coordinates;
    }
}

TEST(Properties, AreColumnsOfCsv) {
    std::istringstream lines(body_of(kThree, {{"sites", "30"}, {"properties", "*"}, {"format", "csv"}}));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "x,y,feature,name,n,tags,x_\r");
    std::map<char, std::size_t> seen;
    while (std::getline(lines, line)) {
        if (line == "break\",,,true\r") continue;
        std::string rest = line.substr(line.find(',', line.find(',') + 1));
        ++seen[rest[1]];
        if (rest[1] == '0') {
            EXPECT_EQ(rest, R"(,0,"a, ""b""",1.5,"{""k"":[1,null]}",)"
                            "\r");
        }
        if (rest[1] == '1') {
            EXPECT_EQ(rest, ",1,\"line");
        }
        if (rest[1] == '2') {
            EXPECT_EQ(rest, ",2,,,,\r");
        }
    }
    EXPECT_EQ(seen.size(), 3U);
    EXPECT_EQ(seen['0'] + seen['1'] + seen['2'], 30U);
}

TEST(Properties, AreListedOnceInJson) {
    const auto json = Json::parse(body_of(kThree, {{"sites", "30"}, {"properties", "tags"}}));
    EXPECT_EQ(json.at("features").size(), 3U);
    EXPECT_EQ(json.at("features").at(0).at("properties").at("tags").dump(), R"({"k":[1,null]})");
    EXPECT_EQ(json.at("features").at(2).at("properties"), Json::object());
    EXPECT_EQ(json.at("feature").size(), 30U);
}

TEST(Properties, OfASingleFeatureBelongToAllPoints) {
    const auto json = Json::parse(
        body_of(square(0, R"({"name":"only"})"), {{"sites", "9"}, {"properties", "*"}, {"format", "geojson"}}));
    ASSERT_EQ(json.at("features").size(), 1U);
    EXPECT_EQ(json.at("features").at(0).at("properties").at("name"), "only");
}

TEST(Properties, AreWrittenForDotMaps) {
    const std::string map = collection(square(0, R"({"people":30,"name":"a"})") + ',' +
                                       square(1, R"({"people":10,"name":"b","class":"old"})"));
    const std::vector<TextOption> options = {{"sites", "people"}, {"properties", "name,class"}};
    auto geojson = options;
    geojson.push_back({"format", "geojson"});
    const auto json = Json::parse(body_of(map, geojson));
    EXPECT_EQ(json.at("features").at(0).at("properties").at("name"), "a");
    EXPECT_EQ(json.at("features").at(0).at("properties").at("sites"), 30);
    EXPECT_EQ(json.at("features").at(1).at("properties").at("class_"), "old");
    auto csv = options;
    csv.push_back({"format", "csv"});
    EXPECT_TRUE(body_of(map, csv).starts_with("x,y,feature,name,class_\r\n"));
    EXPECT_EQ(points_of(map, options), points_of(map, {{"sites", "people"}}));
}

TEST(Properties, StayWithTheirPointsInAnyOrder) {
    for (const std::string order : {"none", "path", "progressive"}) {
        const auto json =
            Json::parse(body_of(kThree, {{"sites", "60"}, {"properties", "*"}, {"order", order}, {"format", "json"}}));
        const auto& points = json.at("points");
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto feature = static_cast<int>(points[i].at(0).get<double>() / 2);
            EXPECT_EQ(feature, json.at("feature").at(i)) << order;
        }
        EXPECT_EQ(json.contains("rank"), order == "progressive");
    }
}

TEST(Properties, AreFoundAcrossTheAntimeridian) {
    const std::string east = R"({"type":"Feature","properties":{"n":"east"},"geometry":{"type":"Polygon",)"
                             R"("coordinates":[[[170,0],[180,0],[180,9],[170,9],[170,0]]]}})";
    const std::string west = R"({"type":"Feature","properties":{"n":"west"},"geometry":{"type":"Polygon",)"
                             R"("coordinates":[[[-180,0],[-170,0],[-170,9],[-180,9],[-180,0]]]}})";
    const auto json =
        Json::parse(body_of(collection(east + ',' + west),
                            {{"sites", "40"}, {"coordinates", "lonlat"}, {"properties", "n"}, {"format", "geojson"}}));
    ASSERT_EQ(json.at("features").size(), 2U);
    for (const Json& feature : json.at("features")) {
        const bool is_east = feature.at("properties").at("n") == "east";
        for (const Json& point : feature.at("geometry").at("coordinates"))
            EXPECT_EQ(point.at(0).get<double>() > 0, is_east);
    }
}

TEST(Properties, RequireFeatures) {
    const std::string polygon = R"({"sites":9,"polygon":[[0,0],[1,0],[0,1]],"properties":"*"})";
    EXPECT_EQ(error_of(polygon, {}).field, "/properties");
    const std::string geometry = R"({"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1]]]})";
    const Error error = error_of(geometry, {{"sites", "9"}, {"properties", "*"}});
    EXPECT_EQ(error.code, ErrorCode::Malformed);
    EXPECT_EQ(error.field, "properties");
    EXPECT_EQ(error_of(kThree, {{"sites", "9"}, {"properties", "nmae"}}).field, "properties");
    EXPECT_EQ(error_of(kThree, {{"sites", "9"}, {"properties", "*"}, {"mesh", "true"}}).field, "mesh");
}

TEST(Properties, AreLimitedInTotalSize) {
    const std::string huge = collection(square(0, "{\"people\":20000,\"a\":\"" + std::string(60'000, 'x') + "\"}"));
    for (const std::string format : {"csv", "ndjson"}) {
        const Error map = error_of(huge, {{"sites", "people"}, {"properties", "a"}, {"format", format}});
        EXPECT_EQ(map.code, ErrorCode::LimitExceeded);
        EXPECT_EQ(map.field, "properties");
        const Error area =
            error_of(huge, {{"sites", "20000"}, {"iterations", "0"}, {"properties", "a"}, {"format", format}});
        EXPECT_EQ(area.code, ErrorCode::LimitExceeded);
    }
    EXPECT_LT(body_of(huge, {{"sites", "people"}, {"iterations", "0"}, {"properties", "a"}}).size(), 2'000'000U);
}

TEST(Properties, CountTowardsTheSizeOfARequest) {
    const std::string text = collection(square(0, "{\"a\":\"" + std::string(60'000, 'x') + "\"}"));
    const auto without = parse_sample(text, {{"sites", "9"}}, "", {});
    const auto with = parse_sample(text, {{"sites", "9"}, {"properties", "*"}}, "", {});
    ASSERT_TRUE(without && with);
    EXPECT_GE(size_of(*with), size_of(*without) + 60'000);
}

/// Takes an answer in pieces, and records the size of the largest.
class Pieces : public BodySink {
public:
    Result<void> begin(const Answer&) override { return {}; }
    Result<void> write(std::string_view piece) override {
        size += piece.size();
        return {};
    }
    std::size_t size = 0;
};

TEST(Properties, AreStreamed) {
    const std::string text = collection(square(0, "{\"a\":\"" + std::string(60'000, 'x') + "\"}"));
    for (const std::string format : {"csv", "ndjson", "geojsonseq"}) {
        const auto request = parse_sample(
            text, {{"sites", "1000"}, {"iterations", "0"}, {"properties", "*"}, {"format", format}}, "", {});
        ASSERT_TRUE(request) << request.error().message;
        Pieces pieces;
        Timings timings;
        const auto result = run_sample(*request, {}, decode_inline(), {}, timings, &pieces);
        ASSERT_TRUE(result);
        EXPECT_TRUE(result->streamed);
        EXPECT_GT(pieces.size, 60'000'000U) << format;
    }
}

std::vector<Json> lines_of(const std::string& body) {
    std::vector<Json> lines;
    std::istringstream stream(body);
    for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
    return lines;
}

const std::string kRectangle = R"({"sites":20,"domain":{"type":"rectangle","width":2,"height":1})";

TEST(JsonLines, ContainOneFeaturePerPoint) {
    const auto lines = lines_of(answer(kRectangle + R"(,"format":"ndjson"})")->body);
    const auto points = Json::parse(answer(kRectangle + "}")->body).at("points");
    ASSERT_EQ(lines.size(), 20U);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        EXPECT_EQ(lines[i].dump(), R"({"geometry":{"coordinates":)" + points[i].dump() +
                                       R"(,"type":"Point"},"properties":{},"type":"Feature"})");
    }
}

TEST(JsonLines, ContainRanks) {
    const auto lines = lines_of(answer(kRectangle + R"(,"format":"ndjson","order":"progressive"})")->body);
    for (std::size_t i = 0; i < lines.size(); ++i) EXPECT_EQ(lines[i].at("properties"), Json({{"rank", i}}));
}

TEST(JsonLines, ContainIdAndPropertiesOfTheFeature) {
    const auto lines = lines_of(body_of(kThree, {{"sites", "30"}, {"properties", "n"}, {"format", "ndjson"}}));
    ASSERT_EQ(lines.size(), 30U);
    for (const Json& line : lines) {
        const auto feature = static_cast<int>(line.at("geometry").at("coordinates").at(0).get<double>() / 2);
        Json expected = {{"feature", feature}};
        if (feature == 0) expected.update({{"n", 1.5}, {"feature_id", "w"}});
        if (feature == 1) expected.update({{"n", nullptr}});
        EXPECT_EQ(line.at("properties"), expected);
    }
}

TEST(JsonLines, ContainTheClassesOfADotMap) {
    const std::string map = collection(square(0, R"({"cats":3,"dogs":2})"));
    const auto lines = lines_of(body_of(map, {{"classes", "cats,dogs"}, {"format", "ndjson"}}));
    ASSERT_EQ(lines.size(), 5U);
    EXPECT_EQ(lines[0].at("properties"), Json({{"feature", 0}, {"class", "cats"}, {"color", "#0072b2"}}));
    EXPECT_EQ(lines[4].at("properties").at("class"), "dogs");
}

TEST(JsonLines, BeginWithARecordSeparatorInATextSequence) {
    const std::string lines = answer(kRectangle + R"(,"format":"ndjson"})")->body;
    const auto request = parse_sample(kRectangle + "}", {}, "application/geo+json-seq", {});
    ASSERT_TRUE(request) << request.error().message;
    Timings timings;
    const auto result = run_sample(*request, {}, decode_inline(), {}, timings);
    EXPECT_EQ(result->media_type, "application/geo+json-seq");
    std::string sequence = result->body;
    EXPECT_EQ(std::ranges::count(sequence, '\x1e'), 20);
    EXPECT_EQ(sequence.front(), '\x1e');
    std::erase(sequence, '\x1e');
    EXPECT_EQ(sequence, lines);
}

TEST(Multipoint, WritesOneFeaturePerPointIfFalse) {
    const auto json = Json::parse(answer(kRectangle + R"(,"format":"geojson","multipoint":false})")->body);
    EXPECT_EQ(json.at("type"), "FeatureCollection");
    EXPECT_EQ(json.at("sites"), 20);
    EXPECT_EQ(json.at("seed"), 0);
    const auto points = Json::parse(answer(kRectangle + "}")->body).at("points");
    ASSERT_EQ(json.at("features").size(), 20U);
    for (std::size_t i = 0; i < 20; ++i) {
        EXPECT_EQ(json.at("features")[i].at("geometry").at("type"), "Point");
        EXPECT_EQ(json.at("features")[i].at("geometry").at("coordinates"), points[i]);
    }
}

TEST(Multipoint, WritesOneFeaturePerPointOfADotMapIfFalse) {
    const std::string map = collection(square(0, R"({"people":3,"name":"a"})") + ',' + square(1, R"({"people":2})"));
    const auto json = Json::parse(
        body_of(map, {{"sites", "people"}, {"format", "geojson"}, {"multipoint", "false"}, {"properties", "name"}}));
    ASSERT_EQ(json.at("features").size(), 5U);
    EXPECT_EQ(json.at("features")[2].at("properties"), Json({{"name", "a"}, {"feature", 0}}));
    EXPECT_EQ(json.at("features")[3].at("properties"), Json({{"feature", 1}}));
}

const std::string kTopology =
    R"({"type":"Topology","transform":{"scale":[2,2],"translate":[0,0]},"objects":{"all":{"type":"Polygon","arcs":[[0,1]]},)"
    R"("two":{"type":"GeometryCollection","geometries":[{"type":"Polygon","arcs":[[0,2]],"id":7,"properties":{"n":30}},)"
    R"({"type":"Polygon","arcs":[[-3,1]],"properties":{"n":10}}]}},)"
    R"("arcs":[[[1,1],[-1,0],[0,-1],[1,0]],[[1,0],[1,0],[0,1],[-1,0]],[[1,0],[0,1]]]})";

TEST(TopoJson, IsReadAsADocumentAndAsGeometry) {
    const std::vector<TextOption> options = {{"sites", "20"}, {"object", "two"}, {"properties", "n"}};
    const auto document = points_of(kTopology, options);
    const auto member =
        Json::parse(answer(R"({"sites":20,"geometry":)" + kTopology + R"(,"properties":["n"],"object":"two"})")->body);
    EXPECT_EQ(member.at("points").get<std::vector<std::vector<double>>>(), document);
    EXPECT_EQ(member.at("features").at(0).at("id"), 7);
    for (std::size_t i = 0; i < document.size(); ++i)
        EXPECT_EQ(static_cast<int>(document[i][0] / 2), member.at("feature").at(i));
}

TEST(TopoJson, HasFeaturesWithCounts) {
    const auto json = Json::parse(body_of(kTopology, {{"sites", "n"}, {"object", "two"}}));
    EXPECT_EQ(json.at("features").at(0).at("sites"), 30);
    EXPECT_EQ(json.at("features").at(1).at("sites"), 10);
}

TEST(TopoJson, RequiresTheChoiceOfAnObject) {
    EXPECT_EQ(error_of(kTopology, {{"sites", "9"}}).field, "/objects");
    EXPECT_EQ(error_of(kTopology, {{"sites", "9"}, {"object", "other"}}).field, "/objects");
    EXPECT_EQ(error_of(kThree, {{"sites", "9"}, {"object", "two"}}).field, "object");
    EXPECT_TRUE(answer(kTopology, {{"sites", "9"}, {"object", "all"}}));
}

}  // namespace
}  // namespace ccdt::api
