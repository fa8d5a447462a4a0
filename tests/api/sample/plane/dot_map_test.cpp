// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "api/sample/plane/sample_cost.h"
#include "api/sample/plane/sample_parser.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

/// A square feature with the lower left corner at x.
std::string square(int x, const std::string& properties, const std::string& id = "") {
    const std::string west = std::to_string(x), east = std::to_string(x + 1);
    return R"({"type":"Feature",)" + (id.empty() ? "" : "\"id\":" + id + ',') + R"("properties":)" + properties +
           R"(,"geometry":{"type":"Polygon","coordinates":[[[)" + west + ",0],[" + east + ",0],[" + east + ",1],[" +
           west + ",1],[" + west + ",0]]]}}";
}

std::string collection(const std::string& features) {
    return R"({"type":"FeatureCollection","features":[)" + features + "]}";
}

const std::string kTwo =
    collection(square(0, R"({"people":2000,"dogs":400})", "\"west\"") + ',' + square(1, R"({"people":500,"dogs":90})"));

std::string request(const std::string& options, const std::string& geometry = kTwo) {
    return "{" + options + ",\"geometry\":" + geometry + "}";
}

Result<SampleRequest> parse(const std::string& body, const std::vector<TextOption>& options = {}) {
    return parse_sample(body, options, "", {});
}

Result<Answer> answer(const std::string& body) {
    const auto request = parse(body);
    if (!request) return tl::make_unexpected(request.error());
    Timings timings;
    return run_sample(*request, {}, decode_inline(), {}, timings);
}

nlohmann::json map(const std::string& body) {
    const auto result = answer(body);
    EXPECT_TRUE(result) << result.error().message;
    return result ? nlohmann::json::parse(result->body) : nlohmann::json();
}

Error error_of(const std::string& body, const std::vector<TextOption>& options = {}) {
    const auto request = parse(body, options);
    EXPECT_FALSE(request);
    return request ? Error() : request.error();
}

TEST(DotMapRequest, CountsAProperty) {
    for (const std::string sites : {R"("sites":{"property":"people","per":100})", R"("sites":"people","per":100)",
                                    R"("per":100,"sites":{"property":"people"})"}) {
        const auto read = parse(request(sites));
        ASSERT_TRUE(read) << read.error().message;
        ASSERT_TRUE(read->counts);
        EXPECT_EQ(read->run.sites, 25U);
        EXPECT_EQ(read->counts->counts, (std::vector<std::size_t>{20, 5}));
        EXPECT_EQ(read->features->first_part, (std::vector<std::size_t>{0, 1, 2}));
    }
    EXPECT_EQ(parse(request(R"("sites":"people")"))->run.sites, 2500U);
}

TEST(DotMapRequest, ReadsOptionsBesideADocument) {
    const auto read = parse(kTwo, {{"sites", "people"}, {"per", "100"}});
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->run.sites, 25U);
    const auto classes = parse(kTwo, {{"classes", "people, dogs"}, {"per", "10"}});
    ASSERT_TRUE(classes) << classes.error().message;
    EXPECT_EQ(classes->run.sites, 299U);
    EXPECT_FALSE(parse(kTwo, {{"sites", "12"}})->counts);
    EXPECT_EQ(error_of(kTwo, {{"sites", "12"}, {"per", "2"}}).field, "per");
    EXPECT_EQ(error_of(kTwo, {{"sites", "1e400"}}).field, "sites");
}

TEST(DotMapRequest, RefusesConflictingOptions) {
    const std::string square = R"({"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1]]]})";
    const std::pair<std::string, std::string> wrong[] = {
        {request(R"("sites":"people")", square), "/sites"},
        {request(R"("sites":5,"per":2)"), "/per"},
        {request(R"("per":2)"), "/per"},
        {request(R"("sites":5,"classes":["dogs"])"), "/classes"},
        {request(R"("sites":"people","classes":["dogs"])"), "/classes"},
        {request(R"("sites":{"per":2})"), "/per"},
        {request(R"("sites":{})"), "/sites"},
        {request(R"("sites":{"property":"people","per":2},"per":3)"), "/per"},
        {request(R"("sites":{"property":"people","per":0})"), "/sites/per"},
        {request(R"("sites":{"property":3})"), "/sites/property"},
        {request(R"("classes":[])"), "/classes"},
        {request(R"("classes":["a","a"])"), "/classes/1"},
        {request(R"("classes":["a","b","c","d","e","f","g"])"), "/classes"},
        {request(R"("sites":"people","method":"cvt")"), "/method"},
        {request(R"("sites":"people","mesh":true)"), "/mesh"}};
    for (const auto& [body, field] : wrong) {
        const Error error = error_of(body);
        EXPECT_EQ(error.code, ErrorCode::Malformed) << body;
        EXPECT_EQ(error.field, field) << body;
    }
}

TEST(DotMapRequest, CostsMoreForMorePoints) {
    const auto few = parse(request(R"("sites":"people","per":1000)")), many = parse(request(R"("sites":"people")"));
    EXPECT_GT(cost_of(*many, {}).seconds, 10 * cost_of(*few, {}).seconds);
}

TEST(DotMap, WritesTheFeatureOfEachPoint) {
    const auto json = map(request(R"("sites":"people","per":100)"));
    ASSERT_EQ(json["points"].size(), 25U);
    ASSERT_EQ(json["feature"].size(), 25U);
    for (std::size_t i = 0; i < 25; ++i) {
        const double x = json["points"][i][0];
        const int feature = json["feature"][i];
        EXPECT_TRUE(x > feature && x < feature + 1);
    }
    EXPECT_EQ(json["features"], nlohmann::json::parse(R"([{"id":"west","sites":20},{"sites":5}])"));
    EXPECT_EQ(json["sites"], 25);
    EXPECT_FALSE(json.contains("class"));
    EXPECT_FALSE(json.contains("repaired"));
}

TEST(DotMap, WritesTheClassOfEachPoint) {
    const auto json = map(request(R"("classes":["people","dogs"],"per":100)"));
    EXPECT_EQ(json["features"],
              nlohmann::json::parse(R"([{"id":"west","sites":24,"classes":[20,4]},{"sites":6,"classes":[5,1]}])"));
    EXPECT_EQ(json["classes"][1]["name"], "dogs");
    EXPECT_EQ(json["classes"][1]["sites"], 5);
    ASSERT_EQ(json["class"].size(), 30U);
    EXPECT_EQ(std::count(json["class"].begin(), json["class"].end(), 1), 5);
}

TEST(DotMap, SkipsFeaturesWithoutAreaWithAWarning) {
    const std::string flat =
        R"({"type":"Feature","properties":{"people":300},"geometry":{"type":"Polygon","coordinates":[[[5,5],[6,6],[5,5]]]}})";
    const std::string none = R"({"type":"Feature","properties":{"people":100},"geometry":null})";
    const std::string nothing = R"({"type":"Feature","properties":{},"geometry":null})";
    const std::string features = collection(square(0, R"({"people":900})") + ',' + flat + ',' + none + ',' + nothing);
    const auto json = map(request(R"("sites":"people","per":100)", features));
    EXPECT_EQ(json["sites"], 9);
    ASSERT_EQ(json["features"].size(), 4U);
    EXPECT_EQ(json["features"][1]["sites"], 0);
    ASSERT_EQ(json["warnings"].size(), 3U);
    EXPECT_EQ(json["warnings"][0]["pointer"], "/geometry/features/3/properties/people");
    EXPECT_EQ(json["warnings"][1]["pointer"], "/geometry/features/1/geometry/coordinates/0");
    EXPECT_EQ(json["warnings"][1]["detail"], "the polygon has no area: 3 points left out");
    EXPECT_EQ(json["warnings"][2]["pointer"], "/geometry/features/2");

    const auto rejected = answer(request(R"("sites":"people","per":100,"invalid":"reject")", features));
    ASSERT_FALSE(rejected);
    EXPECT_EQ(rejected.error().code, ErrorCode::Unusable);
    EXPECT_EQ(rejected.error().field, "/geometry/features/1/geometry/coordinates/0");
    EXPECT_EQ(answer(request(R"("sites":"people")", collection(flat))).error().field, "/geometry/features");
}

TEST(DotMap, ReportsRepairs) {
    const std::string tie =
        R"({"type":"Feature","properties":{"people":30},"geometry":{"type":"MultiPolygon","coordinates":)"
        R"([[[[7,0],[8,0],[8,1],[7,1]]],[[[2,0],[4,2],[4,0],[2,2]]]]}})";
    const std::string features = collection(square(0, R"({"people":30})") + ',' + tie);
    const auto json = map(request(R"("sites":"people")", features));
    ASSERT_EQ(json["repaired"].size(), 1U);
    const std::string pointer = json["repaired"][0]["pointer"];
    EXPECT_TRUE(pointer.starts_with("/geometry/features/1/geometry/coordinates/1/0")) << pointer;
    EXPECT_EQ(answer(request(R"("sites":"people","invalid":"reject")", features)).error().field, pointer);
}

TEST(DotMap, LocatesAFeatureWithoutDensity) {
    const auto refused =
        answer(request(R"("sites":"people","per":100,"density":{"width":2,"height":1,"values":[1,0]})"));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Unusable);
    EXPECT_EQ(refused.error().field, "/geometry/features/1");
}

/// Checks the number of points of an answer, and calls check(x, y) with each.
template <class Check>
void check_all(const nlohmann::json& json, std::size_t points, Check check) {
    ASSERT_EQ(json["points"].size(), points);
    for (const auto& point : json["points"]) check(point[0].get<double>(), point[1].get<double>());
}

TEST(DotMap, ExcludesAvoidedAreas) {
    for (const std::string coordinates : {"plane", "lonlat"}) {
        const auto json =
            map(request(R"("sites":"people","per":10,"avoid":[[[0.5,0.25],[1.5,0.25],[1.5,0.75],[0.5,0.75]]],)"
                        R"("coordinates":")" +
                        coordinates + '"'));
        EXPECT_EQ(json["features"], nlohmann::json::parse(R"([{"id":"west","sites":200},{"sites":50}])"));
        check_all(json, 250, [](double x, double y) { EXPECT_TRUE(x < 0.5 || x > 1.5 || y < 0.25 || y > 0.75); });
    }
}

TEST(DotMap, ExcludesAvoidedAreasOnAnotherTurnOfTheGlobe) {
    const auto json = map(request(
        R"("sites":"people","per":10,"coordinates":"lonlat","avoid":[[[360.5,-1],[361.5,-1],[361.5,2],[360.5,2]]])"));
    check_all(json, 250, [](double x, double) { EXPECT_TRUE(x < 0.5 || x > 1.5); });
}

TEST(DotMap, KeepsTheBufferFromTheOuterBorder) {
    const auto json = map(request(R"("sites":"people","per":10,"buffer":0.125)"));
    double between = 1;
    check_all(json, 250, [&](double x, double y) {
        EXPECT_TRUE(x >= 0.125 && x <= 1.875 && y >= 0.125 && y <= 0.875) << x << ' ' << y;
        between = std::min(between, std::abs(x - 1));
    });
    EXPECT_LT(between, 0.05);
    const auto apart =
        map(request(R"("sites":"people","per":10,"buffer":0.125,"avoid":[[[0.5,-1],[1.5,-1],[1.5,2],[0.5,2]]])"));
    check_all(apart, 250, [](double x, double) { EXPECT_TRUE(x <= 0.375 || x >= 1.625) << x; });
}

TEST(DotMap, WarnsOfFeaturesThatAreFullyExcluded) {
    const std::string avoid = R"("sites":"people","per":10,"avoid":[[[1,0],[2,0],[2,1],[1,1]]])";
    for (const std::string& rest : {avoid, avoid + R"(,"buffer":0.1)", avoid + R"(,"coordinates":"lonlat")",
                                    avoid + R"(,"coordinates":"lonlat","buffer":9000)"}) {
        const auto json = map(request(rest));
        EXPECT_EQ(json["features"], nlohmann::json::parse(R"([{"id":"west","sites":200},{"sites":0}])")) << rest;
        const auto& warning = json["warnings"].back();
        EXPECT_EQ(warning["pointer"], "/geometry/features/1") << rest;
        EXPECT_EQ(warning["detail"], "nothing is left of the feature: 50 points left out") << rest;
        EXPECT_EQ(answer(request(rest + R"(,"invalid":"reject")")).error().field, "/geometry/features/1") << rest;
    }
    const auto nothing = answer(request(R"("sites":"people","avoid":[[[-1,-1],[3,-1],[3,3],[-1,3]]])"));
    ASSERT_FALSE(nothing);
    EXPECT_EQ(nothing.error().code, ErrorCode::Unusable);
    EXPECT_EQ(nothing.error().field, "/avoid");
    EXPECT_EQ(answer(request(R"("sites":"people","buffer":0.6)")).error().field, "/buffer");
    EXPECT_EQ(answer(request(R"("sites":"people","buffer":70000,"coordinates":"lonlat")")).error().field, "/buffer");
}

TEST(DotMap, ReportsRepairsOfAvoidedAreas) {
    const auto json = map(request(R"("sites":"people","per":10,"avoid":[[[0.2,0.2],[0.4,0.4],[0.4,0.2],[0.2,0.4]]])"));
    ASSERT_EQ(json["repaired"].size(), 1U);
    const std::string pointer = json["repaired"][0]["pointer"];
    EXPECT_TRUE(pointer.starts_with("/avoid/0")) << pointer;
}

TEST(DotMap, IsWrittenInEveryFormat) {
    for (const PointFormat* format : sample_formats()) {
        const std::string name(format->file.name);
        for (const std::string sites :
             {R"("sites":"people","per":100,)", R"("classes":["people","dogs"],"per":100,)"}) {
            const std::string needed = format->vector() != nullptr ? R"("width_mm":100,)"
                                       : format->is_tiled()        ? R"("coordinates":"lonlat",)"
                                                                   : "";
            const auto result = answer(request(sites + needed + R"("format":")" + name + '"'));
            ASSERT_TRUE(result) << result.error().message;
            EXPECT_FALSE(result->body.empty());
        }
    }
}

TEST(DotMap, WritesAFeatureCollectionInGeoJson) {
    const auto result = answer(request(R"("classes":["people","dogs"],"per":100,"format":"geojson")"));
    ASSERT_TRUE(result) << result.error().message;
    const auto json = nlohmann::json::parse(result->body);
    EXPECT_EQ(json["type"], "FeatureCollection");
    ASSERT_EQ(json["features"].size(), 4U);
    const auto& first = json["features"][0];
    EXPECT_EQ(first["id"], "west");
    EXPECT_EQ(first["properties"]["feature"], 0);
    EXPECT_EQ(first["properties"]["class"], "people");
    EXPECT_EQ(first["properties"]["sites"], 20);
    EXPECT_EQ(first["geometry"]["type"], "MultiPoint");
    EXPECT_EQ(first["geometry"]["coordinates"].size(), 20U);
}

TEST(DotMap, EscapesClassNames) {
    const std::string features = collection(square(0, R"({"a,\"b\"<&":3,"c":2})"));
    const std::string classes = R"("classes":["a,\"b\"<&","c"])";
    const auto json = map(request(classes, features));
    EXPECT_EQ(json["classes"][0]["name"], "a,\"b\"<&");
    const auto csv = answer(request(classes + R"(,"format":"csv")", features));
    EXPECT_NE(csv->body.find(",0,\"a,\"\"b\"\"<&\"\r\n"), std::string::npos);
    const auto svg = answer(request(classes + R"(,"format":"svg")", features));
    EXPECT_NE(svg->body.find("label=\"a,&quot;b&quot;&lt;&amp;\""), std::string::npos);
    EXPECT_NE(svg->body.find("id=\"class-1-feature-0\""), std::string::npos);
}

TEST(DotMap, RanksThePointsOfAllFeaturesTogether) {
    const std::string options = R"("classes":["people","dogs"],"per":10,"order":"progressive")";
    const auto json = map(request(options));
    const auto& ranks = json.at("rank");
    ASSERT_EQ(ranks.size(), 299U);
    std::vector<int> people, dogs;
    std::array<int, 2> first_50{};
    for (std::size_t i = 0; i < ranks.size(); ++i) {
        const int rank = ranks[i], feature = json.at("feature")[i];
        const bool is_of_people = json.at("class")[i] == 0;
        (is_of_people ? people : dogs).push_back(rank);
        if (is_of_people && rank < 50) ++first_50[static_cast<std::size_t>(feature)];
        const bool continues =
            i > 0 && json.at("feature")[i - 1] == feature && json.at("class")[i - 1] == json.at("class")[i];
        EXPECT_TRUE(!continues || ranks[i - 1] < rank) << i;
    }
    for (auto* each : {&people, &dogs}) {
        std::ranges::sort(*each);
        for (std::size_t i = 0; i < each->size(); ++i) EXPECT_EQ((*each)[i], static_cast<int>(i));
    }
    EXPECT_NEAR(first_50[0], 40, 3);
    const std::string csv = answer(request(options + R"(,"format":"csv")"))->body;
    EXPECT_TRUE(csv.starts_with("x,y,rank,feature,class\r\n"));
    EXPECT_NE(answer(request(options + R"(,"format":"npy")"))->body.find("'shape': (299, 5)"), std::string::npos);
    const auto features =
        nlohmann::json::parse(answer(request(options + R"(,"format":"geojson")"))->body).at("features");
    EXPECT_EQ(features[0].at("properties").at("rank").size(), 200U);
    const std::string svg = answer(request(options + R"(,"format":"svg")"))->body;
    EXPECT_NE(svg.find(R"(data-rank="249")"), std::string::npos);
}

TEST(DotMap, OrdersPointsAlongAPathInEachFeature) {
    const std::string options = R"("sites":"people","per":10,"coordinates":"lonlat",)";
    const auto usual = map(request(options + R"("seed":1)")),
               path = map(request(options + R"("order":"path","seed":1)"));
    EXPECT_EQ(path.at("feature"), usual.at("feature"));
    EXPECT_NE(path.at("points"), usual.at("points"));
    EXPECT_FALSE(path.contains("rank"));
    EXPECT_EQ(map(request(options + R"("order":"progressive")")).at("rank").size(), 250U);
}

}  // namespace
}  // namespace ccdt::api
