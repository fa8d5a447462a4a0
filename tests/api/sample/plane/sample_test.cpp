// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "api/sample/plane/sample_parser.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

const std::string kSquare = R"("polygon":[[0,0],[4,0],[4,4],[0,4]])";

Result<SampleRequest> parse(const std::string& body, std::string_view accept = "", const Limits& limits = {}) {
    return parse_sample(body, {}, accept, limits);
}

Result<Answer> answer(const std::string& body) {
    const auto request = parse(body);
    if (!request) return tl::make_unexpected(request.error());
    Timings timings;
    return run_sample(*request, {}, decode_inline(), {}, timings);
}

nlohmann::json sample(const std::string& body) {
    const auto result = answer(body);
    EXPECT_TRUE(result) << result.error().message;
    if (!result) return {};
    EXPECT_EQ(result->media_type, "application/json");
    return nlohmann::json::parse(result->body);
}

TEST(SampleRequest, HasDocumentedDefaults) {
    const auto request = parse('{' + kSquare + R"(,"sites":10})");
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->run.sites, 10U);
    EXPECT_EQ(request->run.seed, 0U);
    EXPECT_EQ(request->run.iterations, 5);
    EXPECT_EQ(request->run.passes, 5);
    EXPECT_EQ(request->run.quality, Quality::Standard);
    EXPECT_FALSE(request->run.tolerance);
    EXPECT_FALSE(request->run.keep_mesh);
    EXPECT_TRUE(std::holds_alternative<std::monostate>(request->density));
}

TEST(SampleRequest, ReadsEveryMember) {
    const auto request = parse('{' + kSquare + R"(,"holes":[[[1,1],[2,1],[2,2]]],"sites":10,"seed":3,"iterations":7,
        "passes":2,"tolerance":0.01,"method":"ccdt","mesh":true,"format":"json",
        "density":{"width":2,"height":1,"values":[1,2.5]}})");
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->run.seed, 3U);
    EXPECT_EQ(request->run.iterations, 7);
    EXPECT_EQ(request->run.passes, 2);
    EXPECT_EQ(request->run.tolerance, 0.01);
    EXPECT_TRUE(request->run.keep_mesh);
    const auto& polygon = std::get<PolygonInput>(request->region.domain);
    ASSERT_EQ(polygon.parts.size(), 1U);
    EXPECT_EQ(polygon.parts[0].outer.size(), 4U);
    EXPECT_EQ(polygon.parts[0].holes.size(), 1U);
    EXPECT_EQ(std::get<DensityGrid>(request->density).values, (std::vector<double>{1, 2.5}));
}

TEST(SampleRequest, ReadsQuality) {
    const std::vector<std::pair<std::string, Quality>> words = {
        {"draft", Quality::Draft}, {"standard", Quality::Standard}, {"best", Quality::Best}};
    for (const auto& [word, quality] : words) {
        const auto request = parse('{' + kSquare + R"(,"sites":10,"quality":")" + word + "\"}");
        ASSERT_TRUE(request) << request.error().message;
        EXPECT_EQ(request->run.quality, quality);
    }
    const auto stealthy = parse(R"({"sites":32,"quality":"stealthy","domain":{"type":"torus","width":1,"height":2}})");
    ASSERT_TRUE(stealthy) << stealthy.error().message;
    EXPECT_EQ(stealthy->run.quality, Quality::Stealthy);
}

TEST(SampleRequest, ReadsTorus) {
    const auto request = parse(R"({"sites":10,"domain":{"type":"torus","width":3,"height":2}})");
    ASSERT_TRUE(request) << request.error().message;
    const auto& rectangle = std::get<Rectangle>(request->region.domain);
    EXPECT_TRUE(rectangle.periodic);
    EXPECT_EQ(rectangle.width, 3);
    EXPECT_EQ(rectangle.height, 2);
}

TEST(SampleRequest, ReadsGeoJson) {
    const std::string rings = R"([[[0,0,9],[4,0],[4,4],[0,0]],[[2,1],[3,1],[3,2],[2,1]]])";
    const std::string polygon = R"({"type":"Polygon","bbox":[0,0,4,4],"coordinates":)" + rings + '}';
    const std::string multi = R"({"coordinates":[)" + rings + ',' + rings + R"(],"type":"MultiPolygon"})";
    const std::string feature = R"({"type":"Feature","properties":{"a":[{}]},"id":1,"geometry":)" + multi + '}';
    const std::vector<std::pair<std::string, std::size_t>> cases = {{polygon, 1}, {multi, 2}, {feature, 2}};
    for (const auto& [geometry, parts] : cases) {
        const auto request = parse(R"({"sites":10,"geometry":)" + geometry + '}');
        ASSERT_TRUE(request) << request.error().message;
        const auto& input = std::get<PolygonInput>(request->region.domain);
        ASSERT_EQ(input.parts.size(), parts);
        EXPECT_EQ(input.parts.back().outer.size(), 4U);
        EXPECT_EQ(input.parts.back().outer[1], (Point{4, 0}));
        EXPECT_EQ(input.parts.back().holes.size(), 1U);
    }
}

TEST(SampleRequest, ReadsGeoJsonCollections) {
    const std::string one = R"({"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1]]]})";
    const std::string two = R"({"type":"MultiPolygon","coordinates":[[[[3,0],[4,0],[4,1]]],[[[5,0],[6,0],[6,1]]]]})";
    const std::string geometries = R"({"type":"GeometryCollection","geometries":[)" + one + ',' + two + "]}";
    const std::string none = R"({"type":"Feature","properties":null,"geometry":null})";
    const std::string features = R"({"type":"FeatureCollection","features":[)" + none +
                                 R"(,{"type":"Feature","geometry":)" + two + R"(},{"type":"Feature","geometry":)" +
                                 geometries + "}]}";
    for (const auto& [geometry, parts] : {std::pair(geometries, 3U), std::pair(features, 5U)}) {
        const auto request = parse(R"({"sites":10,"geometry":)" + geometry + '}');
        ASSERT_TRUE(request) << request.error().message;
        EXPECT_EQ(std::get<PolygonInput>(request->region.domain).parts.size(), parts);
    }
    const auto request = parse(R"({"sites":10,"geometry":)" + features + '}');
    const auto& input = std::get<PolygonInput>(request->region.domain);
    EXPECT_EQ(input.parts[2].outer[0], (Point{0, 0}));
    EXPECT_EQ(input.pointer_to("/1/0/2"), "/geometry/features/1/geometry/coordinates/1/0/2");
    EXPECT_EQ(input.pointer_to("/2/0/1"), "/geometry/features/2/geometry/geometries/0/coordinates/0/1");
    EXPECT_EQ(input.pointer_to("/4"), "/geometry/features/2/geometry/geometries/1/coordinates/1");
    EXPECT_EQ(input.pointer_to(""), "");
}

TEST(SampleRequest, ReadsGeoJsonDocumentWithSeparateOptions) {
    const std::string document = R"({"type":"Polygon","coordinates":[[[0,0],[4,4],[4,0],[0,4]]]})";
    const auto request = parse_sample(document, {{"sites", "20"}, {"format", "csv"}, {"mesh", "true"}}, "", {});
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->run.sites, 20U);
    EXPECT_EQ(request->output.format->file.name, "csv");
    EXPECT_TRUE(request->run.keep_mesh);
    Timings timings;
    const auto result = run_sample(*request, {}, decode_inline(), {}, timings);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(nlohmann::json::parse(result->repaired).at(0).at("pointer"), "/coordinates/0/2");

    using Options = std::vector<TextOption>;
    const std::vector<std::pair<Options, std::string>> wrong = {
        {{}, "sites"},
        {{{"sites", "x"}}, "sites"},
        {{{"sites", "9"}, {"polygon", "[[0,0],[1,0],[1,1]]"}}, "polygon"},
        {{{"sites", "9"}, {"density", "1"}}, "density"},
        {{{"sites", "9"}, {"sites", "9"}}, "sites"},
        {{{"sites", "9"}, {"method", "cvt"}, {"passes", "2"}}, "passes"},
    };
    for (const auto& [options, field] : wrong) EXPECT_EQ(parse_sample(document, options, "", {}).error().field, field);
    EXPECT_EQ(parse_sample('{' + kSquare + R"(,"sites":9})", {{"seed", "1"}}, "", {}).error().field, "seed");
    EXPECT_EQ(parse_sample(R"({"type":"Polygon"})", {{"sites", "9"}}, "", {}).error().field, "/coordinates");
    EXPECT_EQ(parse_sample(R"({"type":"Point","coordinates":[1,2]})", {{"sites", "9"}}, "", {}).error().message,
              "the body must be a Polygon, a MultiPolygon, a Feature of one, or a collection of these, not a Point");
}

TEST(SampleRequest, PointsToInvalidMember) {
    const std::string sites = R"(,"sites":10)";
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {kSquare, "/sites"},
        {kSquare + R"(,"sites":0)", "/sites"},
        {kSquare + R"(,"sites":1e30)", "/sites"},
        {kSquare + R"(,"sites":2.5)", "/sites"},
        {kSquare + sites + R"(,"seed":-1)", "/seed"},
        {kSquare + sites + R"(,"tolerance":0)", "/tolerance"},
        {kSquare + sites + R"(,"quality":"good")", "/quality"},
        {kSquare + sites + R"(,"quality":2)", "/quality"},
        {kSquare + sites + R"(,"mesh":1)", "/mesh"},
        {kSquare + sites + R"(,"method":"lloyd")", "/method"},
        {kSquare + sites + R"(,"format":"bmp")", "/format"},
        {kSquare + sites + R"(,"x":1)", "/x"},
        {R"("polygon":7)" + sites, "/polygon"},
        {R"("polygon":[[0,0],[1,0],[1]])" + sites, "/polygon/2"},
        {R"("polygon":[[0,0],[1,0],[1,2,3]])" + sites, "/polygon/2"},
        {R"("polygon":[[0,0],[1,0],[1,"2"]])" + sites, "/polygon/2"},
        {kSquare + R"(,"holes":[[[1,1],[2,1],[2,2]],[[0,null]]])" + sites, "/holes/1/0"},
        {R"("holes":[],"domain":{"type":"rectangle","width":1,"height":1})" + sites, "/holes"},
        {R"("domain":{"type":"sphere","width":1,"height":1})" + sites, "/domain/type"},
        {R"("domain":{"type":"rectangle","width":0,"height":1})" + sites, "/domain/width"},
        {R"("domain":{"type":"rectangle","width":1})" + sites, "/domain"},
        {R"("domain":{"type":"rectangle","width":1,"height":1,"depth":1})" + sites, "/domain/type"},
        {R"("domain":[])" + sites, "/domain"},
        {R"("geometry":{"type":"Point","coordinates":[0,0]})" + sites, "/geometry"},
        {R"("geometry":{"type":"FeatureCollection"})" + sites, "/geometry/features"},
        {R"("geometry":{"type":"FeatureCollection","features":{}})" + sites, "/geometry/features"},
        {R"("geometry":{"type":"GeometryCollection","geometries":[{"type":"Point"}]})" + sites,
         "/geometry/geometries/0"},
        {R"("geometry":{"type":"Polygon"})" + sites, "/geometry/coordinates"},
        {R"("geometry":{"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1]],[[0,0],{}]]})" + sites,
         "/geometry/coordinates/1/1"},
        {R"("geometry":{"type":"MultiPolygon","coordinates":[[[[0,0],[1,0],[1]]]]})" + sites,
         "/geometry/coordinates/0/0/2"},
        {R"("geometry":{"type":"Feature","geometry":{"type":"Polygon","coordinates":[3]}})" + sites,
         "/geometry/geometry/coordinates/0"},
        {kSquare + R"(,"density":{"width":2,"height":2,"values":[1,2,3]})" + sites, "/density/values"},
        {kSquare + R"(,"density":{"width":2,"height":1,"values":[1,-2]})" + sites, "/density/values/1"},
        {kSquare + R"(,"density":{"width":2,"height":1,"values":[1,"2"]})" + sites, "/density/values/1"},
        {kSquare + R"(,"density":{"width":2,"values":[1,2]})" + sites, "/density"},
        {kSquare + R"(,"density":{"width":1.5})" + sites, "/density/width"},
        {kSquare + R"(,"density":{"image":"?"})" + sites, "/density/image"},
        {kSquare + R"(,"density":{})" + sites, "/density"},
        {kSquare + R"(,"density":3)" + sites, "/density"},
        {sites.substr(1), ""},
        {kSquare + R"(,"domain":{"type":"rectangle","width":1,"height":1})" + sites, ""},
    };
    for (const auto& [members, field] : wrong) {
        const auto request = parse('{' + members + '}');
        ASSERT_FALSE(request) << members;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed) << members;
        EXPECT_EQ(request.error().field, field) << members;
    }
}

/// Returns the fields of all errors of a request.
std::vector<std::string> fields_of(const Result<SampleRequest>& request) {
    if (request) return {};
    std::vector<std::string> fields = {request.error().field};
    for (const auto& other : request.error().others) fields.push_back(other.field);
    return fields;
}

TEST(SampleRequest, RestrictsStealthyToUniformToriWithEnoughSites) {
    const std::string torus = R"("domain":{"type":"torus","width":1,"height":2})";
    for (const std::string& wrong : {
             R"("sites":31,)" + torus,
             R"("sites":32,"iterations":0,)" + torus,
             R"("sites":32,"fixed":[[0.5,0.5]],)" + torus,
             R"("sites":32,"density":{"width":1,"height":2,"values":[1,2]},)" + torus,
             R"("sites":32,)" + kSquare,
             std::string(R"("sites":32,"domain":{"type":"rectangle","width":1,"height":1})"),
             std::string(R"("sites":999,"domain":{"type":"torus","width":1e308,"height":1e-308})"),
         }) {
        EXPECT_EQ(fields_of(parse(R"({"quality":"stealthy",)" + wrong + "}")), std::vector<std::string>{"/quality"})
            << wrong;
    }
}

TEST(SampleRequest, ReportsMissingMembersWithInvalidOnes) {
    using Fields = std::vector<std::string>;
    EXPECT_EQ(fields_of(parse("{}")), (Fields{"/sites", ""}));
    EXPECT_EQ(fields_of(parse(R"({"quality":"fine","seed":-1})")), (Fields{"/quality", "/seed", "/sites", ""}));
    EXPECT_EQ(fields_of(parse(R"({"sites":0,"domain":7})")), (Fields{"/sites", "/domain"}));
    EXPECT_EQ(fields_of(parse(R"({"sites":0})")), (Fields{"/sites", ""}));
    EXPECT_EQ(fields_of(parse(R"({"classes":7,"geometry":7})")), (Fields{"/classes", "/geometry"}));
    EXPECT_EQ(fields_of(parse("{")), (Fields{""}));
    const std::string open = R"({"type":"Polygon","coordinates":[[[0,0],[1,0],[1,"x"]]]})";
    EXPECT_EQ(fields_of(parse_sample(open, {{"quality", "fine"}}, "", {})),
              (Fields{"quality", "sites", "/coordinates/0/2"}));
}

TEST(SampleRequest, ReadsAvoidedPolygons) {
    const std::string body = '{' + kSquare + R"(,"sites":1,"avoid":)";
    EXPECT_TRUE(parse('{' + kSquare + R"(,"sites":1})")->region.avoid.parts.empty());
    const auto rings = parse(body + "[[[1,1],[2,1],[2,2]],[[3,3],[4,3],[4,4]]]}");
    ASSERT_TRUE(rings) << rings.error().message;
    ASSERT_EQ(rings->region.avoid.parts.size(), 2U);
    EXPECT_EQ(rings->region.avoid.parts[1].outer[0], (Point{3, 3}));
    EXPECT_EQ(rings->region.avoid.pointer_to("/1/0/2"), "/avoid/1/2");
    const auto polygon = parse(body + R"({"type":"Polygon","coordinates":[[[1,1],[2,1],[2,2]]]}})");
    ASSERT_TRUE(polygon) << polygon.error().message;
    EXPECT_EQ(polygon->region.avoid.pointer_to("/0/0/2"), "/avoid/coordinates/0/2");
    EXPECT_TRUE(parse(body + R"({"type":"FeatureCollection","features":[]}})")->region.avoid.parts.empty());
}

TEST(SampleRequest, ReadsFixedPoints) {
    const std::string body = '{' + kSquare + R"(,"sites":1,"fixed":)";
    const auto fixed = [&](const std::string& value) { return parse(body + value + '}').value().run.fixed; };
    const std::vector<Point> two = {{1, 2}, {3, 1}};
    EXPECT_TRUE(fixed("[]").empty());
    EXPECT_EQ(fixed("[[1,2],[3,1]]"), two);
    const std::string points = R"({"type":"MultiPoint","coordinates":[[1,2,7],[3,1]]})";
    EXPECT_EQ(fixed(points), two);
    EXPECT_EQ(fixed(R"({"type":"FeatureCollection","features":[{"type":"Feature","geometry":null,"properties":{}},
        {"type":"Feature","geometry":)" +
                    points + "}]}"),
              two);
    const auto refused = [&](const std::string& value, ErrorCode code, const std::string& field, const Limits& limits) {
        const auto request = parse(body + value + '}', "", limits);
        ASSERT_FALSE(request) << value;
        EXPECT_EQ(request.error().code, code);
        EXPECT_EQ(request.error().field, field);
    };
    refused("[[1,2],[3]]", ErrorCode::Malformed, "/fixed/1", {});
    refused("7", ErrorCode::Malformed, "/fixed", {});
    refused(R"({"type":"Polygon","coordinates":[]})", ErrorCode::Malformed, "/fixed", {});
    refused("[[1,2],[3,1]]", ErrorCode::LimitExceeded, "/fixed/1", {.max_sites = 1});
    refused(R"([[1,2]],"method":"cvt")", ErrorCode::Malformed, "/fixed", {});
    refused(R"([[1,91]],"coordinates":"lonlat")", ErrorCode::Unusable, "/fixed", {});
}

TEST(SampleRequest, RejectsEmptyGeometry) {
    for (const auto* geometry :
         {R"({"type":"Polygon","coordinates":[]})", R"({"type":"MultiPolygon","coordinates":[]})",
          R"({"type":"MultiPolygon","coordinates":[[]]})", R"({"type":"FeatureCollection","features":[]})"}) {
        const auto request = parse(std::string(R"({"sites":1,"geometry":)") + geometry + '}');
        ASSERT_FALSE(request) << geometry;
        EXPECT_EQ(request.error().code, ErrorCode::Unusable);
    }
}

TEST(SampleRequest, EnforcesLimits) {
    EXPECT_EQ(parse('{' + kSquare + R"(,"sites":11})", "", {.max_sites = 10}).error().code, ErrorCode::LimitExceeded);
    std::string ring = "[[0,0]";
    for (std::size_t i = 0; i < PolygonInput::kMaxCorners; ++i) ring += ",[1,2]";
    const auto request = parse(R"({"sites":1,"polygon":)" + ring + "]}");
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(request.error().field, "/polygon");
}

TEST(SampleRequest, NegotiatesFormat) {
    const std::string body = '{' + kSquare + R"(,"sites":10)";
    EXPECT_EQ(parse(body + '}', "application/*")->output.format->file.name, "json");
    EXPECT_EQ(parse(body + '}', "application/json;q=0.5, text/csv")->output.format->file.name, "csv");
    EXPECT_EQ(parse(body + '}', "application/geo+json")->output.format->file.name, "geojson");
    EXPECT_EQ(parse(body + '}', "application/x-npy")->output.format->file.name, "npy");
    EXPECT_EQ(parse(body + '}', "text/html").error().code, ErrorCode::NotAcceptable);
    EXPECT_EQ(parse(body + R"(,"format":"csv"})", "text/html")->output.format->file.name, "csv");
}

TEST(PlacedSample, HasTheSamePointsInAllFormats) {
    const auto request = *parse('{' + kSquare + R"(,"sites":60,"order":"progressive"})");
    Timings timings;
    const auto placed = *place_sample(request, {}, decode_inline(), {}, timings);
    for (const PointFormat* format : sample_formats()) {
        const std::string name(format->file.name);
        const auto written = write_answer(request, placed, *format, {}, {}, timings);
        if (format->vector() != nullptr && format->vector()->in_millimetres) {
            ASSERT_FALSE(written) << name;
            EXPECT_EQ(written.error().field, "/width_mm");
        } else if (format->is_tiled()) {
            ASSERT_FALSE(written) << name;
            EXPECT_EQ(written.error().field, "/format");
        } else if (format->repeats()) {
            const std::string direct = '{' + kSquare + R"(,"sites":60,"order":"progressive","format":")" + name + "\"}";
            EXPECT_TRUE(written->body == answer(direct)->body) << name;
        }
    }
}

TEST(Sample, PlacesRequestedNumberInsidePolygon) {
    const auto json = sample('{' + kSquare + R"(,"holes":[[[1,1],[3,1],[3,3],[1,3]]],"sites":100,"seed":5})");
    EXPECT_EQ(json.at("sites"), 100);
    EXPECT_EQ(json.at("seed"), 5);
    EXPECT_EQ(json.at("iterations"), 5);
    EXPECT_EQ(json.at("trace").size(), 6U);
    EXPECT_FALSE(json.contains("triangles"));
    EXPECT_FALSE(json.contains("width"));
    ASSERT_EQ(json.at("points").size(), 100U);
    for (const auto& point : json.at("points")) {
        const double x = point[0];
        const double y = point[1];
        EXPECT_TRUE(x > 0 && x < 4 && y > 0 && y < 4);
        EXPECT_FALSE(x > 1 && x < 3 && y > 1 && y < 3);
    }
}

TEST(Sample, KeepsDistanceToFixedPointsOnGround) {
    const auto json = sample(R"({"sites":300,"polygon":[[0,60],[10,60],[10,70],[0,70]],"coordinates":"lonlat",
        "fixed":[[5,65],[5,65],[5.0001,65],[2,62]]})");
    constexpr double kMetres = 111'000;
    for (const auto& point : json.at("points")) {
        for (const Point& fixed : {Point{5, 65}, Point{2, 62}}) {
            const double east = (point[0].get<double>() - fixed.x) * std::cos(fixed.y * std::acos(-1) / 180);
            const double north = point[1].get<double>() - fixed.y;
            EXPECT_GT(kMetres * std::hypot(east, north), 0.7 * json.at("pitch_m").get<double>());
        }
    }
}

TEST(Sample, ReportsMediaTypeOfFormat) {
    const std::vector<std::pair<std::string, std::string>> types = {{"json", "application/json"},
                                                                    {"csv", "text/csv; header=present"},
                                                                    {"geojson", "application/geo+json"},
                                                                    {"npy", "application/x-npy"}};
    for (const auto& [format, type] : types) {
        const auto result = answer('{' + kSquare + R"(,"sites":10,"format":")" + format + "\"}");
        ASSERT_TRUE(result) << format;
        EXPECT_EQ(result->media_type, type);
        EXPECT_EQ(result->sites, 10U);
    }
}

TEST(Sample, ReadsRealCountries) {
    for (const auto* name : {"South-Africa-50m.geojson", "Switzerland-10m.geojson", "Italy-110m.geojson"}) {
        const auto json = sample(R"({"sites":200,"geometry":)" + polygon_file(name) + '}');
        EXPECT_EQ(json.at("points").size(), 200U) << name;
    }
}

TEST(Sample, ReturnsTheMeshOnRequest) {
    const auto json = sample('{' + kSquare + R"(,"sites":50,"mesh":true})");
    EXPECT_GE(json.at("vertices").size(), 50U);
    EXPECT_EQ(json.at("vertices")[0], json.at("points")[0]);
    EXPECT_GT(json.at("triangles").size(), 50U);
    EXPECT_EQ(json.at("boundary").size(), 1U);
}

/// Returns the share of the points above `middle`.
double share_above(const nlohmann::json& json, double middle) {
    const auto& points = json.at("points");
    const auto above = std::count_if(points.begin(), points.end(), [&](const auto& p) { return p[1] > middle; });
    return static_cast<double>(above) / static_cast<double>(points.size());
}

TEST(Sample, PutsFirstRowOfDensityGridAtBottom) {
    const auto json = sample(R"({"sites":400,"domain":{"type":"rectangle","width":10,"height":4},
        "density":{"width":1,"height":2,"values":[3,1]}})");
    EXPECT_NEAR(share_above(json, 2), 0.25, 0.03);
}

TEST(Sample, PutsFirstRowOfDensityImageAtTop) {
    // A black pixel above a white one.
    const auto json = sample(R"({"sites":100,"domain":{"type":"rectangle","width":10,"height":4},"density":{"image":
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAACCAAAAAC86un7AAAADElEQVR4nGNgYPgPAAEDAQAIicLsAAAAAElFTkSuQmCC"}})");
    EXPECT_GT(share_above(json, 2), 0.95);
}

TEST(Sample, PointsToFaultOfInvalidPolygon) {
    const std::string bow = "[[0,0],[4,4],[4,0],[0,4]]";
    const std::string good = "[[0,0],[4,0],[4,4],[0,4]]";
    const std::string far = "[[9,9],[10,9],[10,10]]";
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {R"("polygon":)" + bow, "/polygon/"},
        {R"("polygon":)" + good + R"(,"holes":[[[1,1],[2,1],[2,2]],)" + far + ']', "/holes/1"},
        {R"("geometry":{"type":"Polygon","coordinates":[)" + bow + "]}", "/geometry/coordinates/0/"},
        {R"("geometry":{"type":"MultiPolygon","coordinates":[[)" + far + "],[" + bow + "]]}",
         "/geometry/coordinates/1/0/"},
        {R"("geometry":{"type":"Feature","geometry":{"type":"Polygon","coordinates":[)" + good + ',' + far + "]}}",
         "/geometry/geometry/coordinates/1"},
        {R"("polygon":[[0,0],[1,1]])", "/polygon"},
    };
    for (const auto& [members, field] : wrong) {
        const auto result = answer('{' + members + R"(,"sites":10,"invalid":"reject"})");
        ASSERT_FALSE(result) << members;
        EXPECT_EQ(result.error().code, ErrorCode::Unusable) << members;
        EXPECT_TRUE(result.error().field.starts_with(field)) << result.error().field << " for " << members;
    }
}

TEST(Sample, RepairsPolygonsAndReportsIt) {
    const std::string bow = R"({"geometry":{"type":"Polygon","coordinates":[[[0,0],[4,4],[4,0],[0,4]]]},"sites":20)";
    const nlohmann::json fault = {{"pointer", "/geometry/coordinates/0/2"},
                                  {"detail", "the outer ring of part 0 crosses itself at (2, 2)"}};
    const auto expected = nlohmann::json::array({fault});
    const auto json = sample(bow + '}');
    EXPECT_EQ(json.at("points").size(), 20u);
    EXPECT_EQ(json.at("repaired"), expected);
    EXPECT_EQ(sample(bow + R"(,"invalid":"repair"})").at("points"), json.at("points"));
    for (const char* format : {"csv", "geojson", "npy", "svg", "png"}) {
        const auto result = answer(bow + R"(,"format":")" + format + "\"}");
        ASSERT_TRUE(result) << format;
        EXPECT_EQ(nlohmann::json::parse(result->repaired), expected) << format;
    }
    EXPECT_TRUE(answer(bow + '}')->repaired.empty()) << "JSON reports it in the body";
    EXPECT_FALSE(sample('{' + kSquare + R"(,"sites":3})").contains("repaired"));
}

TEST(Sample, WarnsIfCoordinatesLookLikeDegrees) {
    const auto box = [](double west, double south, double east, double north) {
        const auto ring = nlohmann::json{{{west, south}, {east, south}, {east, north}, {west, north}}};
        const nlohmann::json polygon = {{"type", "Polygon"}, {"coordinates", ring}};
        return R"({"sites":20,"geometry":)" + polygon.dump();
    };
    const std::string norway = box(5, 58, 31, 71);
    const auto json = sample(norway + '}');
    const std::string detail =
        "points are even in degrees, not on the ground: if these are longitudes and latitudes, there are 1.63 times as "
        "many to a square kilometre at latitude 71 as at 58";
    const auto expected = nlohmann::json::array({{{"pointer", "/geometry/coordinates"}, {"detail", detail}}});
    EXPECT_EQ(json.at("warnings"), expected);
    EXPECT_TRUE(answer(norway + '}')->warnings.empty()) << "JSON reports it in the body";
    for (const char* format : {"csv", "geojson", "svg"})
        EXPECT_EQ(nlohmann::json::parse(answer(norway + R"(,"format":")" + format + "\"}")->warnings), expected);
    EXPECT_TRUE(sample(box(-180, -90, 180, 90) + '}').contains("warnings"));
    EXPECT_TRUE(sample(box(-60, -55, -50, 0) + '}').contains("warnings"));
    for (const auto& plane : {box(0, 0, 10, 10), box(0, 40, 5, 45), box(0, 0, 1000, 80), box(0, 0, 10, 91)})
        EXPECT_FALSE(sample(plane + '}').contains("warnings")) << plane;
    EXPECT_FALSE(sample(R"({"sites":9,"polygon":[[0,0],[80,0],[80,80]]})").contains("warnings"));
}

TEST(Sample, IsUniformOnGroundForCoordinatesInDegrees) {
    const std::string box = R"({"polygon":[[170,0],[200,0],[200,80],[170,80]],"sites":1000,"coordinates":"lonlat")";
    const auto json = sample(box + '}');
    EXPECT_FALSE(json.contains("warnings"));
    EXPECT_NEAR(json.at("pitch_m"), 145'000, 1'500);
    int north = 0, east = 0;
    for (const auto& point : json.at("points")) {
        const double longitude = point[0], latitude = point[1];
        ASSERT_TRUE(longitude > 170 || longitude < -160);
        ASSERT_LE(std::abs(longitude), 180);
        north += latitude > 30 ? 1 : 0;
        east += longitude < 0 ? 1 : 0;
    }
    EXPECT_NEAR(north, 492, 15) << "about 1 - sin 30 degrees / sin 80 degrees of the area";
    EXPECT_NEAR(east, 667, 15);
    EXPECT_NE(sample(box + R"(,"method":"cvt"})").at("points"), json.at("points"));
    const auto feature = nlohmann::json::parse(answer(box + R"(,"format":"geojson"})")->body);
    EXPECT_EQ(feature.at("properties").at("pitch_m"), json.at("pitch_m"));
    for (const char* format : {"svg", "png", "csv", "npy"})
        EXPECT_TRUE(answer(box + R"(,"format":")" + format + "\"}")) << format;
}

TEST(Sample, RejectsCoordinatesOffTheGlobe) {
    const std::string lonlat = R"(,"sites":9,"coordinates":"lonlat"})";
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {R"({"polygon":[[0,0],[1,0],[1,91]])", "/polygon/2"},
        {R"({"polygon":[[0,0],[1e308,0],[1,9]])", "/polygon/1"},
        {R"({"geometry":{"type":"Polygon","coordinates":[[[0,0],[9,0],[9,9]],[[0,0],[9,-99],[9,9]]]})",
         "/geometry/coordinates/1/1"},
    };
    for (const auto& [members, field] : wrong) {
        const auto result = answer(members + lonlat);
        ASSERT_FALSE(result) << members;
        EXPECT_EQ(result.error().code, ErrorCode::Unusable);
        EXPECT_EQ(result.error().field, field);
    }
    // The reader adds an edge along the pole, which crosses the other part.
    const auto tip = sample(R"({"geometry":{"type":"MultiPolygon","coordinates":[[[[0,80],[120,80],[240,80]]],
        [[[10,89],[20,89],[20,90],[10,90]]]]})" +
                            lonlat);
    for (const auto& repair : tip.at("repaired")) {
        const std::string pointer = repair.at("pointer");
        EXPECT_TRUE(pointer == "/geometry/coordinates/0/0" || pointer.starts_with("/geometry/coordinates/1/0"));
    }
    const auto torus = answer(R"({"domain":{"type":"torus","width":1,"height":1})" + lonlat);
    ASSERT_FALSE(torus);
    EXPECT_EQ(torus.error().field, "/coordinates");
}

TEST(Sample, PolishesUnlessQualityIsDraft) {
    const std::string body = '{' + kSquare + R"(,"sites":300,"seed":2)";
    const auto draft = sample(body + R"(,"quality":"draft"})"), standard = sample(body + '}');
    EXPECT_EQ(standard.at("points"), sample(body + R"(,"quality":"standard"})").at("points"));
    EXPECT_NE(standard.at("points"), draft.at("points"));
    EXPECT_NE(sample(body + R"(,"quality":"best"})").at("points"), standard.at("points"));
    EXPECT_EQ(draft.at("variation"), draft.at("trace").back().at("variation"));
    EXPECT_NE(standard.at("variation"), standard.at("trace").back().at("variation"));
}

TEST(Sample, FillsTorus) {
    const auto json = sample(R"({"sites":200,"domain":{"type":"torus","width":3,"height":2},"mesh":true})");
    ASSERT_EQ(json.at("points").size(), 200U);
    for (const auto& point : json.at("points")) {
        const double x = point[0];
        const double y = point[1];
        EXPECT_TRUE(x >= 0 && x < 3 && y >= 0 && y < 2) << x << ' ' << y;
    }
    EXPECT_EQ(json.at("vertices"), json.at("points"));
    EXPECT_EQ(json.at("triangles").size(), 400U);
    EXPECT_TRUE(json.at("boundary").empty());
}

TEST(Sample, RejectsElongatedTorus) {
    const auto result = answer(R"({"sites":10,"domain":{"type":"torus","width":1001,"height":1}})");
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
    EXPECT_EQ(result.error().field, "/domain");
}

TEST(Sample, RejectsZeroDensity) {
    const auto result = answer('{' + kSquare + R"(,"sites":10,"density":{"width":2,"height":1,"values":[0,0]}})");
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
    EXPECT_TRUE(result.error().field.starts_with("/density"));
}

/// Checks that an answer contains neither NaN nor infinity, for which JSON has null.
void expect_numbers(const Answer& answer, const std::string& request) {
    for (const std::string_view word : {"null", "nan", "inf"})
        EXPECT_EQ(answer.body.find(word), std::string::npos) << word << " for " << request;
}

TEST(Sample, DependsOnRatiosOfDensitiesOnly) {
    const std::vector<std::string> domains = {
        R"("polygon":[[0,0],[2,0],[2,1],[1.5,1.5],[0,1]])",
        R"("domain":{"type":"rectangle","width":2,"height":1})",
        R"("domain":{"type":"torus","width":2,"height":1})",
    };
    const std::vector<std::string> values = {"1e-300,1e-300", "0,5e-324", "1e-200,3e-200",  "5e-324,1",
                                             "1e-310,1",      "1,1e308",  "1.7e308,1.7e308"};
    for (const auto& domain : domains) {
        for (const std::string method : {"ccdt", "cvt", "odt", "ccvt", "random"}) {
            for (const auto& pair : values) {
                const std::string body = '{' + domain + R"(,"sites":9,"method":")" + method +
                                         R"(","density":{"width":2,"height":1,"values":[)" + pair + "]}}";
                const auto result = answer(body);
                ASSERT_TRUE(result) << body << result.error().message;
                expect_numbers(*result, body);
                EXPECT_EQ(nlohmann::json::parse(result->body).at("points").size(), 9) << body;
            }
        }
    }
}

TEST(Sample, IsUnchangedIfDensityIsScaledByPowerOfTwo) {
    const auto points = [](const std::string& values) {
        return sample('{' + kSquare + R"(,"sites":50,"density":{"width":3,"height":1,"values":[)" + values + "]}}")
            .at("points");
    };
    EXPECT_EQ(points("1,3,0.25"), points("1024,3072,256"));
    EXPECT_EQ(points("1,3,0.25"), points("0.0009765625,0.0029296875,0.000244140625"));
    EXPECT_NE(points("1,3,0.25"), points("1,3,0.5"));
}

TEST(Sample, WritesExtremeNumbers) {
    for (const std::string side : {"1e-140", "1", "1e140"}) {
        for (const std::string& shape : {R"({"type":"rectangle","width":)" + side + R"(,"height":)" + side + '}',
                                         R"({"type":"torus","width":)" + side + R"(,"height":)" + side + '}'}) {
            for (const std::string format : {"json", "geojson", "csv", "svg", "png"}) {
                for (const std::string drawing : {"", R"(,"dot":5e-324)", R"(,"dot":1.7e308)",
                                                  R"(,"dot":1e308,"style":"stroke","width_mm":10000)"}) {
                    const std::string body = R"({"sites":3,"domain":)" + shape + R"(,"format":")" + format + '"' +
                                             (format == "png" && drawing.size() > 20 ? "" : drawing) + '}';
                    const auto result = answer(body);
                    ASSERT_TRUE(result) << body << result.error().message;
                    if (format != "png") expect_numbers(*result, body);
                }
            }
        }
    }
}

TEST(Sample, DrawsForPlottersAtTheEndsOfRanges) {
    for (const std::string side : {"1e-140", "1", "1e140"}) {
        for (const std::string format : {"svg", "pdf", "eps", "hpgl", "gcode", "dxf"}) {
            for (const std::string style : {"fill", "stroke", "circles", "spiral", "path"}) {
                for (const std::string drawing :
                     {R"("width_mm":1)", R"("width_mm":10000,"dot":5e-324)", R"("width_mm":1,"dot":1e308,"pen":100)",
                      R"("width_mm":10000,"dot":1e308,"pen":0.01)"}) {
                    const bool has_turns = style == "circles" || style == "spiral";
                    if (!has_turns && drawing.find("pen") != std::string::npos) continue;
                    const std::string body = R"({"sites":3,"domain":{"type":"rectangle","width":)" + side +
                                             R"(,"height":)" + side + R"(},"format":")" + format + R"(","style":")" +
                                             style + "\"," + drawing + '}';
                    const auto result = answer(body);
                    if (!result) {
                        EXPECT_EQ(result.error().code, ErrorCode::Unusable) << body;
                        EXPECT_EQ(result.error().field, "/pen") << body;
                        continue;
                    }
                    ASSERT_TRUE(result->plot) << body;
                    EXPECT_TRUE(std::isfinite(result->plot->seconds)) << body;
                    if (format != "pdf") {
                        EXPECT_EQ(result->body.find("nan"), std::string::npos) << body;
                        EXPECT_EQ(result->body.find("inf"), std::string::npos) << body;
                    }
                }
            }
        }
    }
}

TEST(Sample, ChecksPensAndPagesBeforePointsArePlaced) {
    for (const auto& [more, field] : std::vector<std::pair<std::string, std::string>>{
             {R"("format":"svg","width_mm":100,"style":"spiral","pen":0.01,"dot":0.4)", "/pen"},
             {R"("format":"svg","paper":"a4","margin":105)", "/margin"},
             {R"("format":"dxf","width_mm":10000,"domain":{"type":"rectangle","width":1,"height":1000})",
              "/width_mm"}}) {
        const std::string domain = R"("domain":{"type":"rectangle","width":1,"height":1},)";
        const std::string body =
            R"({"sites":300,)" + (more.find("domain") == std::string::npos ? domain : "") + more + '}';
        const auto request = parse_sample(body, {}, "", {});
        ASSERT_TRUE(request) << request.error().message;
        Timings timings;
        const auto refused = run_sample(*request, {}, decode_inline(), {}, timings);
        ASSERT_FALSE(refused) << body;
        EXPECT_EQ(refused.error().field, field);
        EXPECT_EQ(timings.optimise, 0) << body;
    }
}

TEST(Sample, DrawsNoNeedlesForPlotters) {
    for (const std::string height : {"1e-9", "1e9"}) {
        const auto result = answer(
            R"({"sites":3,"format":"pdf","width_mm":100,"method":"random","domain":{"type":"rectangle","width":1,"height":)" +
            height + "}}");
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, ErrorCode::Unusable);
        EXPECT_EQ(result.error().field, "/width_mm");
    }
}

TEST(Sample, StopsOnRequest) {
    std::stop_source stop;
    const auto request = parse('{' + kSquare + R"(,"sites":100})");
    Timings timings;
    const Control control{stop.get_token(), [&](const Progress&) { stop.request_stop(); }};
    const auto result = run_sample(*request, {}, decode_inline(), control, timings);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Stopped);
}

TEST(Sample, ReturnsPartialResultOnRequest) {
    for (const bool stopped : {false, true}) {
        std::stop_source stop;
        const auto request = parse('{' + kSquare + R"(,"sites":100,"on_deadline":"partial"})");
        Timings timings;
        const Control control{stop.get_token(), [&](const Progress& progress) {
                                  if (stopped && progress.iteration == 2) stop.request_stop();
                              }};
        const auto result = run_sample(*request, {}, decode_inline(), control, timings);
        ASSERT_TRUE(result);
        EXPECT_EQ(result->partial, stopped);
        const auto answer = nlohmann::json::parse(result->body);
        EXPECT_EQ(answer.value("partial", false), stopped);
        EXPECT_EQ(answer["iterations"], stopped ? 2 : 5);
        EXPECT_EQ(answer["points"].size(), 100);
    }
    EXPECT_FALSE(parse('{' + kSquare + R"(,"sites":100,"on_deadline":"best"})"));
}

const std::string kTwenty = kSquare + R"(,"sites":20)";

/// Returns the points in sorted order.
nlohmann::json sorted(nlohmann::json points) {
    std::sort(points.begin(), points.end());
    return points;
}

TEST(SampleOrder, ChangesOrderOnly) {
    const auto usual = sample('{' + kTwenty + '}');
    EXPECT_EQ(sample('{' + kTwenty + R"(,"order":"none"})").at("points"), usual.at("points"));
    for (const std::string order : {"path", "progressive"}) {
        const auto ordered = sample('{' + kTwenty + R"(,"order":")" + order + "\"}");
        EXPECT_NE(ordered.at("points"), usual.at("points"));
        EXPECT_EQ(sorted(ordered.at("points")), sorted(usual.at("points")));
        EXPECT_EQ(ordered.contains("rank"), order == "progressive");
    }
    EXPECT_FALSE(parse('{' + kTwenty + R"(,"order":"random"})"));
}

TEST(SampleOrder, WritesRanksInEveryFormat) {
    const std::string body = '{' + kTwenty + R"(,"order":"progressive","format":")";
    std::vector<int> ranks(20);
    std::iota(ranks.begin(), ranks.end(), 0);
    EXPECT_EQ(sample(body + "json\"}").at("rank"), nlohmann::json(ranks));
    const auto feature = nlohmann::json::parse(answer(body + "geojson\"}")->body);
    EXPECT_EQ(feature.at("properties").at("rank"), nlohmann::json(ranks));
    const std::string csv = answer(body + "csv\"}")->body;
    EXPECT_TRUE(csv.starts_with("x,y,rank\r\n")) << csv;
    EXPECT_TRUE(csv.ends_with(",19\r\n")) << csv;
    const std::string npy = answer(body + "npy\"}")->body;
    EXPECT_NE(npy.find("'shape': (20, 3)"), std::string::npos);
    double last = 0;
    std::memcpy(&last, npy.data() + npy.size() - sizeof last, sizeof last);
    EXPECT_EQ(last, 19);
    const std::string svg = answer(body + "svg\"}")->body;
    EXPECT_LT(svg.find(R"(data-rank="3")"), svg.find(R"(data-rank="4")"));
    EXPECT_NE(svg.find(R"(data-rank="19")"), std::string::npos);
}

TEST(SampleOrder, DefaultsToPathForDrawings) {
    const std::string body = '{' + kTwenty + R"(,"format":"svg")";
    const std::string usual = answer(body + '}')->body;
    EXPECT_EQ(answer(body + R"(,"order":"path"})")->body, usual);
    EXPECT_NE(answer(body + R"(,"order":"none"})")->body, usual);
}

TEST(SampleOrder, ReordersMesh) {
    const auto json = sample('{' + kTwenty + R"(,"order":"progressive","mesh":true})");
    for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(json.at("vertices")[i], json.at("points")[i]);
}

TEST(SampleOrder, StopsOnRequest) {
    Timings timings;
    std::stop_source source;
    source.request_stop();
    const std::string body = '{' + kTwenty + R"(,"iterations":0,"order":"progressive")";
    EXPECT_FALSE(run_sample(*parse(body + '}'), {}, decode_inline(), {source.get_token(), {}}, timings));
}

TEST(Sample, KeepsBuffersOfFineBordersAtAnyScale) {
    // Squares of these scales are beyond the range of doubles.
    constexpr int kCorners = 60'000;
    const auto points = [](double scale) {
        nlohmann::json corners;
        for (int i = 0; i < kCorners; ++i) {
            const double angle = 2 * std::numbers::pi * i / kCorners, radius = scale * (i % 2 == 0 ? 1 : 0.5);
            corners.push_back({radius * std::cos(angle), radius * std::sin(angle)});
        }
        const nlohmann::json request{{"sites", 20}, {"buffer", 1e-3 * scale}, {"polygon", corners}};
        return sample(request.dump()).at("points");
    };
    const auto usual = points(1);
    for (const double scale : {0x1p-450, 0x1p450}) {
        const auto scaled = points(scale);
        ASSERT_EQ(scaled.size(), usual.size());
        for (std::size_t i = 0; i < scaled.size(); ++i) {
            for (std::size_t k = 0; k < 2; ++k)
                EXPECT_NEAR(scaled[i][k].get<double>() / scale, usual[i][k].get<double>(), 1e-9) << scale;
        }
    }
}

}  // namespace
}  // namespace ccdt::api
