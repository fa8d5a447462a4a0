// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/map_drawing.h"

#include <algorithm>
#include <cstddef>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "api/output/letters.h"
#include "api/sample/plane/sample.h"
#include "api/sample/plane/sample_parser.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

/// A feature in GeoJSON whose ring has the given corners.
std::string feature(const std::string& ring, const std::string& properties) {
    return R"({"type":"Feature","properties":)" + properties + R"(,"geometry":{"type":"Polygon","coordinates":[[)" +
           ring + "]]}}";
}

std::string collection(const std::string& features) {
    return R"({"type":"FeatureCollection","features":[)" + features + "]}";
}

// The lower right corner of the map is free.
const std::string kWest = feature("[6,46],[8,46],[8,48],[6,48],[6,46]", R"({"people":4000,"a & b":400})");
const std::string kEast = feature("[8,47.2],[10,47.2],[10,48],[8,48],[8,47.2]", R"({"people":1000,"a & b":90})");
const std::string kTwo = collection(kWest + ',' + kEast);
const std::string kClasses = R"("classes":["people","a & b"],"per":10,)";
const std::string kLonLat = R"("coordinates":"lonlat",)";

Result<Answer> answer(const std::string& options, const std::string& geometry = kTwo) {
    const auto request = parse_sample("{" + options + ",\"geometry\":" + geometry + "}", {}, "", {});
    if (!request) return tl::make_unexpected(request.error());
    Timings timings;
    return run_sample(*request, {}, decode_inline(), {}, timings);
}

std::string drawn(const std::string& options, const std::string& geometry = kTwo) {
    const auto result = answer(options, geometry);
    EXPECT_TRUE(result) << result.error().message;
    return result ? result->body : "";
}

/// Returns the numbers that a pattern with one group finds.
std::vector<double> numbers(const std::string& text, const std::string& pattern) {
    const std::regex expression(pattern);
    std::vector<double> found;
    for (std::sregex_iterator i(text.begin(), text.end(), expression); i != std::sregex_iterator(); ++i)
        found.push_back(std::stod((*i)[1]));
    return found;
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

double ratio_of(const std::string& svg) {
    return numbers(svg, R"re(viewBox="0 0 ([0-9.]+))re").front() /
           numbers(svg, R"re(viewBox="0 0 [0-9.]+ ([0-9.]+))re").front();
}

TEST(MapDrawing, HasTheProportionsOfTheGround) {
    const std::string switzerland = R"({"type":"Polygon","coordinates":[[[6,46],[10,46],[10,48],[6,48],[6,46]]]})";
    EXPECT_NEAR(ratio_of(drawn(R"("sites":50,"format":"svg")", switzerland)), 2, 0.001);
    const std::string options = kLonLat + R"("sites":50,"format":"svg")";
    EXPECT_NEAR(ratio_of(drawn(options, switzerland)), 1.38, 0.01);
    const std::string fiji = R"({"type":"MultiPolygon","coordinates":[
        [[[178,-18],[180,-18],[180,-16],[178,-16],[178,-18]]],[[[-180,-18],[-178,-18],[-178,-16],[-180,-16],[-180,-18]]]]})";
    EXPECT_NEAR(ratio_of(drawn(options, fiji)), 1.92, 0.02);
}

TEST(MapDrawing, KeepsDotsInsideTheDrawing) {
    const std::string svg = drawn(kLonLat + kClasses + R"("width_mm":100,"format":"svg")");
    const auto x = numbers(svg, R"re(<circle class="class-\d" cx="([-0-9.]+))re");
    ASSERT_EQ(x.size(), 549U);
    EXPECT_GT(std::ranges::min(x), 0);
    EXPECT_LT(std::ranges::max(x), 100);
}

TEST(MapDrawing, AlternatesTheDotsOfClasses) {
    const std::string svg = drawn(kLonLat + kClasses + R"("format":"svg")");
    const auto classes = numbers(svg, R"re(<circle class="class-(\d)")re");
    for (std::size_t first = 0; first + 44 <= 440; first += 44)
        EXPECT_EQ(std::count(classes.begin() + static_cast<std::ptrdiff_t>(first),
                             classes.begin() + static_cast<std::ptrdiff_t>(first + 44), 1.0),
                  4)
            << first;
    EXPECT_TRUE(has(svg, ".class-0{fill:#0072b2}.class-1{fill:#d55e00}"));
    EXPECT_FALSE(has(svg, "multiply"));
    EXPECT_TRUE(has(svg, R"(<g id="feature-1">)"));
}

TEST(MapDrawing, KeepsRanks) {
    const auto ranks =
        numbers(drawn(kLonLat + kClasses + R"("order":"progressive","format":"svg")"), R"re(data-rank="(\d+))re");
    EXPECT_EQ(ranks.size(), 549U);
    EXPECT_EQ(std::ranges::max(ranks), 499);
}

TEST(MapDrawing, HasDotsAsSmallAsDensePlacesAsk) {
    const std::string dense = feature("[8,46],[8.1,46],[8.1,46.1],[8,46.1],[8,46]", R"({"people":40000})");
    const std::string sparse = feature("[6,47],[10,47],[10,48],[6,48],[6,47]", R"({"people":1000})");
    const auto radius = [&](const std::string& features) {
        return numbers(
                   drawn(kLonLat + R"("sites":"people","per":10,"width_mm":1000,"format":"svg")", collection(features)),
                   R"re(<circle class="class-0" cx="[-0-9.]+" cy="[-0-9.]+" r="([0-9.]+))re")
            .front();
    };
    EXPECT_NEAR(radius(sparse), 1000 / 2.74 * std::sqrt(2.7 / 100) / 3, 0.5);
    EXPECT_NEAR(radius(sparse + ',' + dense), 1000 * 0.001 / 3, 0.03) << "the least radius";
}

TEST(MapDrawing, DescribesClassesAndTheUnitInALegend) {
    const std::string svg = drawn(kLonLat + kClasses + R"("format":"svg")");
    EXPECT_TRUE(has(svg, ">people</text>"));
    EXPECT_TRUE(has(svg, ">a &amp; b</text>"));
    EXPECT_TRUE(has(svg, ">1 dot = 10</text>"));
    EXPECT_TRUE(has(drawn(kLonLat + R"("sites":"people","per":2.5,"format":"svg")"), ">1 dot = 2.5 people</text>"));
    const std::string without = drawn(kLonLat + kClasses + R"("legend":false,"outlines":false,"format":"svg")");
    EXPECT_FALSE(has(without, "legend"));
    EXPECT_FALSE(has(without, "outlines"));
    EXPECT_TRUE(has(without, "class-1"));
}

TEST(MapDrawing, PlacesTheLegendWhereTheMapIsFree) {
    const std::string options = kLonLat + kClasses + R"("format":"svg")";
    EXPECT_NEAR(ratio_of(drawn(options)), 1.36, 0.01) << "in the lower right corner";
    const std::string full =
        collection(kWest + ',' + feature("[8,46],[10,46],[10,48],[8,48],[8,46]", R"({"people":9,"a & b":9})"));
    EXPECT_LT(ratio_of(drawn(options, full)), 1.28) << "below the map";
}

TEST(MapDrawing, OfThePlaneIsAMapOnlyOnRequest) {
    const std::string usual = drawn(kClasses + R"("format":"svg")");
    EXPECT_FALSE(has(usual, "outlines"));
    EXPECT_TRUE(has(usual, R"(inkscape:groupmode="layer")"));
    EXPECT_TRUE(has(drawn(kClasses + R"("outlines":true,"format":"svg")"), R"(<g id="outlines")"));
    EXPECT_TRUE(has(drawn(kClasses + R"("legend":true,"format":"svg")"), R"(<g id="legend")"));
    EXPECT_TRUE(has(drawn(R"("sites":9,"outlines":true,"format":"svg")"), R"(<g id="outlines")"));
}

TEST(MapDrawing, IsLeftToPensInLayers) {
    const std::string svg = drawn(kLonLat + kClasses + R"("width_mm":100,"style":"stroke","format":"svg")");
    EXPECT_TRUE(has(svg, R"(inkscape:groupmode="layer")"));
    EXPECT_FALSE(has(svg, "legend"));
}

TEST(MapDrawing, RefusesOptionsWithoutEffect) {
    const auto refused = [](const std::string& options, const std::string& field) {
        const auto result = answer(options);
        ASSERT_FALSE(result) << options;
        EXPECT_EQ(result.error().field, field) << options;
    };
    refused(kClasses + R"("outlines":true)", "/outlines");
    refused(kClasses + R"("legend":false,"format":"csv")", "/legend");
    refused(kClasses + R"("legend":true,"format":"gcode","width_mm":100)", "/legend");
    refused(kClasses + R"("outlines":true,"format":"svg","style":"stroke")", "/outlines");
    refused(kClasses + R"("outlines":true,"format":"svg","split":"ink","width_mm":100)", "/outlines");
    refused(R"("sites":9,"legend":true,"format":"svg")", "/legend");
}

TEST(MapDrawing, IsWrittenInTheSameWayEveryTime) {
    for (const std::string format : {"svg", "pdf", "eps", "png", "jpeg"}) {
        const std::string size = format == "png" || format == "jpeg" ? R"("width":300,)" : R"("width_mm":100,)";
        const std::string options = kLonLat + kClasses + size + R"("format":")" + format + '"';
        const std::string first = drawn(options);
        EXPECT_FALSE(first.empty());
        EXPECT_EQ(first, drawn(options)) << format;
    }
}

TEST(Letters, AreOutlinesAboveTheBaseline) {
    const auto rings = letters("HO", 10);
    ASSERT_EQ(rings.size(), 3U) << "O has two";
    for (const Ring& ring : rings) {
        for (const Point& p : ring) {
            EXPECT_LE(p.y, 0.3);
            EXPECT_GE(p.y, -8);
        }
    }
    EXPECT_TRUE(letters("", 10).empty());
}

}  // namespace
}  // namespace ccdt::api
