// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/analyze/analyze.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/api/files.h"

namespace ccdt::api {
namespace {

const std::string kPoints = R"("points":[[0.1,0.2],[0.6,0.7],[0.3,0.9],[0.8,0.4]])";
const std::string kSets = R"("sets":[[[1,1],[2,1]],[[1,0.5],[3,1.5]],[[0.5,0.5],[2.5,2]]])";
const std::string kSpacePoints = R"("points":[[0.1,0.2,0.3],[0.6,0.7,0],[0.3,0.9,1]])";
const std::string kTorus = R"("domain":{"type":"torus","width":3,"height":2})";

Result<AnalyzeRequest> parse(const std::string& body, std::string_view accept = "", const Limits& limits = {}) {
    return parse_analyze(body, accept, limits);
}

Result<Answer> answer(const std::string& body, std::string_view accept = "") {
    const auto request = parse(body, accept);
    if (!request) return tl::make_unexpected(request.error());
    Timings timings;
    return run_analyze(*request, {}, timings);
}

nlohmann::json analyzed(const std::string& body) {
    const auto result = answer(body);
    EXPECT_TRUE(result) << result.error().message;
    return result ? nlohmann::json::parse(result->body) : nlohmann::json();
}

/// Returns a square lattice of side x side points on the unit square.
std::string lattice(int side) {
    std::string points;
    for (int i = 0; i < side * side; ++i) {
        points += points.empty() ? "" : ",";
        points += '[' + std::to_string((i % side + 0.5) / side) + ',' + std::to_string((i / side + 0.5) / side) + ']';
    }
    return "\"points\":[" + points + ']';
}

TEST(AnalyzeRequest, HasTheDocumentedDefaults) {
    const auto request = parse('{' + kPoints + '}');
    ASSERT_TRUE(request) << request.error().message;
    const auto& [sets, domain, polygon] = std::get<PlaneSets>(request->points);
    ASSERT_EQ(sets.size(), 1U);
    EXPECT_EQ(sets[0][1], (Point{0.6, 0.7}));
    EXPECT_EQ(domain.width, 1);
    EXPECT_EQ(domain.height, 1);
    EXPECT_TRUE(domain.periodic);
    EXPECT_FALSE(polygon);
    EXPECT_EQ(request->options.max_frequency, 4);
    EXPECT_FALSE(request->spectrum);
    EXPECT_EQ(request->format->file.name, "json");
}

TEST(AnalyzeRequest, ReadsEveryMember) {
    const auto request = parse('{' + kSets + R"(,"domain":{"type":"rectangle","width":3,"height":2},"spectrum":true,
        "max_frequency":2.5,"format":"svg"})");
    ASSERT_TRUE(request) << request.error().message;
    const auto& [sets, domain, polygon] = std::get<PlaneSets>(request->points);
    ASSERT_EQ(sets.size(), 3U);
    EXPECT_EQ(sets[1][1], (Point{3, 1.5}));
    EXPECT_EQ(domain.width, 3);
    EXPECT_EQ(domain.height, 2);
    EXPECT_FALSE(domain.periodic);
    EXPECT_FALSE(polygon);
    EXPECT_EQ(request->options.max_frequency, 2.5);
    EXPECT_TRUE(request->spectrum);
    EXPECT_EQ(request->format->file.name, "svg");
}

TEST(AnalyzeRequest, ReadsPointsInSpace) {
    const auto request = parse('{' + kSpacePoints + '}');
    ASSERT_TRUE(request) << request.error().message;
    const auto& [sets, domain] = std::get<SpaceSets>(request->points);
    ASSERT_EQ(sets.size(), 1U);
    EXPECT_EQ(sets[0][1], (Point3{0.6, 0.7, 0}));
    EXPECT_EQ(domain.sides, (Point3{1, 1, 1}));
    EXPECT_TRUE(domain.periodic);
    EXPECT_EQ(request->options.max_frequency, 2);
    const auto box = parse('{' + kSpacePoints + R"(,"domain":{"type":"box","width":1.5,"height":1.25,"depth":2}})");
    ASSERT_TRUE(box) << box.error().message;
    EXPECT_EQ(std::get<SpaceSets>(box->points).domain.sides, (Point3{1.5, 1.25, 2}));
    EXPECT_FALSE(std::get<SpaceSets>(box->points).domain.periodic);
}

TEST(AnalyzeRequest, LocatesErrorsByJsonPointer) {
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {"", ""},
        {kPoints + ',' + kSets, ""},
        {R"("points":7)", "/points"},
        {R"("points":[[0,0],[1]])", "/points/1"},
        {R"("points":[[0,0],[1,2,3]])", "/points/1"},
        {R"("points":[[0,0],[1,null]])", "/points/1"},
        {R"("sets":7)", "/sets"},
        {R"("sets":[[[0,0],[1,1]],7])", "/sets/1"},
        {R"("sets":[[[0,0],[1,1]],[[0,0],"1"]])", "/sets/1/1"},
        {kPoints + R"(,"domain":{"type":"sphere","width":1,"height":1})", "/domain/type"},
        {kPoints + R"(,"domain":{"type":"torus","width":1,"height":-1})", "/domain/height"},
        {kPoints + R"(,"domain":{"type":"torus","width":1})", "/domain"},
        {kPoints + R"(,"domain":{"width":1,"height":1})", "/domain"},
        {kPoints + R"(,"domain":[])", "/domain"},
        {kPoints + R"(,"domain":{"type":"box","width":1,"height":1,"depth":1})", "/domain"},
        {kSpacePoints + R"(,"domain":{"type":"box","width":1,"height":1})", "/domain"},
        {kSpacePoints + R"(,"domain":{"type":"rectangle","width":1,"height":1,"depth":1})", "/domain/type"},
        {kSpacePoints + R"(,"domain":{"type":"torus","width":1,"height":1})", "/domain"},
        {R"("points":[[0,0,0],[1,1]])", "/points/1"},
        {R"("sets":[[[0,0,0],[1,1,1]],[[0,0],[1,1]]])", "/sets/1/0"},
        {kPoints + R"(,"holes":[])", "/holes"},
        {kPoints + R"(,"polygon":[[0,0],[1]])", "/polygon/1"},
        {kPoints + R"(,"geometry":{"type":"Point","coordinates":[0,0]})", "/geometry"},
        {kPoints + R"(,"polygon":[[0,0],[1,0],[0,1]],"domain":{"type":"torus","width":1,"height":1})", ""},
        {kSpacePoints + R"(,"polygon":[[0,0],[1,0],[0,1]])", "/polygon"},
        {kPoints + R"(,"spectrum":1)", "/spectrum"},
        {kPoints + R"(,"max_frequency":0.5)", "/max_frequency"},
        {kPoints + R"(,"max_frequency":17)", "/max_frequency"},
        {kPoints + R"(,"format":"gif")", "/format"},
        {kPoints + R"(,"seed":1)", "/seed"},
    };
    for (const auto& [members, field] : wrong) {
        const auto request = parse('{' + members + '}');
        ASSERT_FALSE(request) << members;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed) << members;
        EXPECT_EQ(request.error().field, field) << members;
    }
}

TEST(AnalyzeRequest, RefusesMorePointsThanTheLimit) {
    for (const auto& [members, field] : {std::pair{kPoints, "/points"}, std::pair{kSets, "/sets"}}) {
        const auto request = parse('{' + members + '}', "", {.max_sites = 3});
        ASSERT_FALSE(request);
        EXPECT_EQ(request.error().code, ErrorCode::LimitExceeded);
        EXPECT_EQ(request.error().field, field);
        EXPECT_NE(request.error().message.find("max-sites"), std::string::npos);
    }
    EXPECT_TRUE(parse('{' + kSets + ',' + kTorus + '}', "", {.max_sites = 6}));
}

TEST(AnalyzeRequest, NegotiatesTheFormat) {
    const std::string body = '{' + kPoints + '}';
    EXPECT_EQ(parse(body, "*/*")->format->file.name, "json");
    EXPECT_EQ(parse(body, "image/*")->format->file.name, "png");
    EXPECT_EQ(parse(body, "image/svg+xml, application/json;q=0.5")->format->file.name, "svg");
    EXPECT_EQ(parse(body, "text/csv").error().code, ErrorCode::NotAcceptable);
    EXPECT_EQ(parse('{' + kPoints + R"(,"format":"png"})", "text/csv")->format->file.name, "png");
}

TEST(Analyze, WritesTheDocumentedMembers) {
    const auto json = analyzed('{' + kSets + ',' + kTorus + '}');
    EXPECT_EQ(json.at("sets"), 3);
    const auto rings = json.at("frequency").size();
    EXPECT_GT(rings, 3U);
    EXPECT_EQ(json.at("power").size(), rings);
    EXPECT_EQ(json.at("anisotropy_db").size(), rings);
    EXPECT_TRUE(json.at("min_distance").is_number());
    EXPECT_TRUE(json.at("mean_distance").is_number());
    EXPECT_TRUE(json.contains("low_frequency_power"));
    EXPECT_EQ(json.size(), 7U);
}

TEST(Analyze, MeasuresALattice) {
    const auto json = analyzed('{' + lattice(10) + R"(,"spectrum":true,"max_frequency":2})");
    EXPECT_NEAR(json.at("min_distance"), 0.1 / std::sqrt(2 / std::sqrt(3.0) / 100), 1e-6);
    EXPECT_NEAR(json.at("low_frequency_power"), 0, 1e-12);
    const auto& spectrum = json.at("spectrum");
    EXPECT_EQ(spectrum.at("width"), 41);
    EXPECT_EQ(spectrum.at("height"), 41);
    ASSERT_EQ(spectrum.at("values").size(), 41U * 41U);
    for (std::size_t i = 0; i < 41 * 41; ++i) {
        const auto x = static_cast<int>(i % 41) - 20, y = static_cast<int>(i / 41) - 20;
        const bool peak = x % 10 == 0 && y % 10 == 0 && (x != 0 || y != 0);
        EXPECT_NEAR(spectrum.at("values")[i], peak ? 100 : 0, 1e-4) << x << ", " << y;
    }
}

TEST(Analyze, HasNoLowFrequencyPowerForFourPoints) {
    EXPECT_TRUE(analyzed('{' + kPoints + '}').at("low_frequency_power").is_null());
    EXPECT_TRUE(analyzed('{' + lattice(5) + '}').at("low_frequency_power").is_number());
}

TEST(AnalyzeRequest, LocatesPointsThatCannotBeAnalyzed) {
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {R"("points":[[0.5,0.5]])", "/points"},
        {R"("points":[])", "/points"},
        {R"("points":[[0.5,0.5],[0.5,1.5]])", "/points/1"},
        {R"("sets":[])", "/sets"},
        {R"("sets":[[[0,0],[1,1]],[[0,0]]])", "/sets/1"},
        {R"("sets":[[[0,0],[1,1]],[[0,0],[0,1],[1,0]]])", "/sets/1"},
        {R"("sets":[[[0,0],[1,1]],[[0,0],[-0.5,0]]])", "/sets/1/1"},
        {kPoints + R"(,"domain":{"type":"torus","width":1e6,"height":1})", "/domain"},
        {R"("points":[[0,0],[1,1]],"domain":{"type":"rectangle","width":1,"height":1})", "/points"},
        {R"("points":[[0,0,0],[1,1,2]])", "/points/1"},
        {R"("points":[[0,0,0],[1,1,1]],"domain":{"type":"box","width":1,"height":1,"depth":1})", "/points"},
    };
    for (const auto& [members, field] : wrong) {
        const auto result = parse('{' + members + '}');
        ASSERT_FALSE(result) << members;
        EXPECT_EQ(result.error().code, ErrorCode::Unusable) << members;
        EXPECT_EQ(result.error().field, field) << members;
    }
}

TEST(Analyze, LocatesErrorsOfPolygons) {
    const std::string polygon = R"(,"polygon":)", triangle = "[[0,0],[4,0],[0,4]]";
    const std::string points = R"("points":[[0.5,0.5],[0.5,1],[1,0.5],[3,3]])";
    const std::string part = "[[[0,0],[4,0],[0.2,0.2],[0,4],[0,0]]]";
    const std::string multi = R"(,"geometry":{"type":"MultiPolygon","coordinates":[)";
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {points + polygon + triangle, "/points/3"},
        {points + polygon + "[[0,0],[1e200,0],[0,1e200]]", "/polygon"},
        {points + polygon + "[]", "/polygon"},
        {points + polygon + "[[0,0],[1,1],[2,2]]", "/polygon"},
        {points + polygon + "[[0,0],[4,4],[4,4.001],[0,0.001]]", "/polygon"},
        {points + polygon + "[[0,0],[4,4],[4,4.03],[0,0.03]]", "/points/0"},
        {points + multi + part + ',' + part + ',' + part + "]}", "/geometry/coordinates"},
    };
    for (const auto& [members, field] : wrong) {
        Timings timings;
        const auto answer = run_analyze(parse('{' + members + '}').value(), {}, timings);
        ASSERT_FALSE(answer) << members;
        EXPECT_EQ(answer.error().code, ErrorCode::Unusable) << members;
        EXPECT_EQ(answer.error().field, field) << members << answer.error().message;
    }
}

TEST(AnalyzeRequest, NamesTheLimitOfTheTransform) {
    const auto result = parse('{' + lattice(370) + R"(,"max_frequency":16})");
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(result.error().field, "/max_frequency");
    EXPECT_NE(result.error().message.find(std::to_string(kMaxTransformCells)), std::string::npos);
}

std::size_t count(const std::string& text, std::string_view word) {
    std::size_t found = 0;
    for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
    return found;
}

TEST(Analyze, DrawsThePlotAsSvg) {
    const auto result = answer('{' + kSets + ',' + kTorus + R"(,"format":"svg"})");
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(result->media_type, "image/svg+xml");
    const std::string& svg = result->body;
    EXPECT_TRUE(svg.starts_with("<svg "));
    EXPECT_EQ(count(svg, "<svg "), count(svg, "</svg>"));
    EXPECT_EQ(count(svg, "h0"), 2U) << "a dot for each point of the first set";
    EXPECT_EQ(count(svg, "<polyline"), 2U);
    EXPECT_EQ(count(svg, "data:image/png;base64,"), 1U);
    for (const auto* words :
         {"2 points, first of 3 sets", "white noise", "isotropic", "Power spectrum", "Anisotropy"}) {
        EXPECT_NE(svg.find(words), std::string::npos) << words;
    }
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(Analyze, MeasuresAndDrawsPointsInSpace) {
    std::string points;
    for (int i = 0; i < 64; ++i) {
        points += (i > 0 ? ",[" : "[") + std::to_string(i % 4 / 4.0) + ',' + std::to_string(i / 4 % 4 / 2.0) + ',' +
                  std::to_string(i / 16 / 4.0) + ']';
    }
    const std::string body =
        R"({"points":[)" + points + R"(],"spectrum":true,"domain":{"type":"torus","width":1,"height":2,"depth":1}})";
    const auto json = analyzed(body);
    EXPECT_NEAR(json.at("min_distance"), 0.25 / (1.122462 / std::cbrt(32)), 1e-6);
    EXPECT_NEAR(json.at("low_frequency_power"), 0, 1e-12);
    const auto& spectrum = json.at("spectrum");
    const int width = spectrum.at("width"), height = spectrum.at("height");
    EXPECT_GT(height, width);
    for (std::size_t i = 0; i < spectrum.at("values").size(); ++i) {
        const int x = static_cast<int>(i) % width - width / 2, y = static_cast<int>(i) / width - height / 2;
        const bool peak = x % 4 == 0 && y % 4 == 0 && (x != 0 || y != 0);
        EXPECT_NEAR(spectrum.at("values")[i], peak ? 64 : 0, 1e-6) << x << ", " << y;
    }
    const auto plot = answer(body, "image/svg+xml");
    ASSERT_TRUE(plot) << plot.error().message;
    EXPECT_EQ(count(plot->body, "h0"), 64U) << "four layers of points, one in each slab";
    for (const auto* words : {"64 points", "25 to 50 % of the depth", "Slice of the power spectrum", "volume"})
        EXPECT_NE(plot->body.find(words), std::string::npos) << words;
}

TEST(Analyze, ShowsOnlyTheMiddleOfManyPoints) {
    const auto result = answer('{' + lattice(100) + R"(,"max_frequency":1,"format":"svg"})");
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_NE(result->body.find("the middle: 2,500 of 10,000 points"), std::string::npos);
    EXPECT_EQ(count(result->body, "h0"), 2500U);
}

/// Whether any pixel of a box is dark.
bool has_ink(const DecodedPng& png, int left, int top, int right, int bottom) {
    for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
            if (png.at(x, y)[0] < 128) return true;
        }
    }
    return false;
}

TEST(Analyze, DrawsThePlotAsPng) {
    const auto result = answer('{' + kPoints + R"(,"format":"png"})");
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(result->media_type, "image/png");
    const auto png = decode_png(result->body);
    EXPECT_EQ(png.width, 3000);
    EXPECT_EQ(png.height, 1080);
    EXPECT_TRUE(has_ink(png, 100, 120, 900, 920)) << "points";
    EXPECT_TRUE(has_ink(png, 1100, 120, 1800, 920)) << "spectrum";
    EXPECT_TRUE(has_ink(png, 2040, 120, 2800, 460)) << "power";
    EXPECT_TRUE(has_ink(png, 2040, 580, 2800, 920)) << "anisotropy";
    EXPECT_FALSE(has_ink(png, 0, 0, 70, 1080)) << "margin";
    // The y axis points up: the point (0.1, 0.2) lies in the lower left of the panel.
    EXPECT_EQ(png.at(80 + 84, 940 - 168)[0], 0);
    EXPECT_EQ(png.at(80 + 84, 100 + 168)[0], 255);
}

TEST(Analyze, IsDeterministic) {
    for (const auto* format : {"json", "svg", "png"}) {
        const std::string body = '{' + kSets + ',' + kTorus + R"(,"format":")" + format + "\"}";
        EXPECT_EQ(answer(body).value().body, answer(body).value().body) << format;
    }
}

TEST(Analyze, StopsOnRequest) {
    std::stop_source stop;
    stop.request_stop();
    const auto request = parse('{' + kPoints + '}');
    Timings timings;
    const auto result = run_analyze(*request, {stop.get_token(), {}}, timings);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Stopped);
    EXPECT_EQ(result.error().field, "");
}

}  // namespace
}  // namespace ccdt::api
