// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "api/output/npy_header.h"
#include "api/sample/choice/choice_parser.h"
#include "api/sample/choice/choice_sample.h"

namespace ccdt::api {
namespace {

using Json = nlohmann::json;

Result<Answer> run(const std::string& file, std::vector<TextOption> options, std::string_view accept = "") {
    options.insert(options.begin(), {"candidates", "body"});
    EXPECT_TRUE(asks_for_choice(options));
    const auto request = parse_choice(file, options, accept, {});
    if (!request) return tl::unexpected(request.error());
    Timings timings;
    return run_choice(*request, {}, {}, {}, timings);
}

std::string body_of(const std::string& file, const std::vector<TextOption>& options, std::string_view accept = "") {
    const auto answer = run(file, options, accept);
    EXPECT_TRUE(answer) << (answer ? "" : answer.error().message);
    return answer ? answer->body : std::string();
}

/// Returns the field and the message of an error.
std::string error_of(const std::string& file, const std::vector<TextOption>& options) {
    const auto answer = run(file, options);
    return answer ? "none" : answer.error().field + ": " + answer.error().message;
}

std::string feature(int x, const std::string& properties = "{}") {
    return R"({"type": "Feature","geometry":{"type":"Point","coordinates":[)" + std::to_string(x) +
           R"(,0]},"properties":)" + properties + ",\"z\": 1.0}";
}

TEST(ChoiceFile, AnswersWithRecordsOfCsv) {
    const std::string head = "\xEF\xBB\xBFname;x;y\r\n", a = "\"a;\r\n\"\"b\";0;0\r\n", b = "c;0.10;0\r\n",
                      c = " d ;5;1e0";
    EXPECT_EQ(body_of(head + a + b + c, {{"sites", "2"}}), head + b + c + "\n");
    EXPECT_EQ(body_of(head + a + b + c, {{"sites", "3"}}), head + a + b + c + "\n");
    EXPECT_EQ(body_of(head, {{"sites", "0"}}), head);
    const std::string tabs =
        "gbifID\tnote\tdecimalLatitude\tdecimalLongitude\n1\t\"\t46.5\t7\n2\t5\"\t\t\n3\t\t47\t8\n";
    const Json answer = Json::parse(body_of(tabs, {{"sites", "2"}, {"format", "json"}}));
    EXPECT_EQ(answer.at("indices"), Json({0, 2}));
    EXPECT_EQ(answer.at("points"), Json({{7, 46.5}, {8, 47}}));
    EXPECT_EQ(answer.at("warnings").at(0).at("detail"), "records without coordinates are left out: 1");
}

TEST(ChoiceFile, AnswersWithFeatures) {
    const std::string head = "{\"name\":1.0,\"features\": [", tail = "],\"type\":\"FeatureCollection\"}\n";
    const std::string features = feature(0) + ",\n " + feature(1) + "," + feature(9);
    EXPECT_EQ(body_of(head + features + tail, {{"sites", "2"}}),
              head + "\n" + feature(1) + ",\n" + feature(9) + "\n" + tail);
    const std::string lines = feature(0) + "\n" + feature(1) + "\n\n" + feature(9);
    EXPECT_EQ(body_of(lines, {{"sites", "2"}}), feature(1) + "\n" + feature(9) + "\n");
    const std::string sequence = "\x1E" + feature(0) + "\n\x1E" + feature(1) + "\n\x1E" + feature(9) + "\n";
    EXPECT_EQ(body_of(sequence, {{"sites", "2"}}), "\x1E" + feature(1) + "\n\x1E" + feature(9) + "\n");
}

TEST(ChoiceFile, AnswersWithVerticesOfAPly) {
    const std::string head = "ply\nformat ascii 1.0\ncomment c\nelement vertex ";
    const std::string rest =
        "\nproperty uchar red\nproperty float x\nproperty float y\nproperty float z\nproperty list uchar int near\n";
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
    const std::string rows = "1 0 0 0 0\n2 .1 0 0 2 7 8\n3 5 0 0 0\n";
    EXPECT_EQ(body_of(head + "3" + rest + faces + "end_header\n" + rows + "3 0 1 2\n", {{"sites", "2"}}),
              head + "2" + rest + "end_header\n2 .1 0 0 2 7 8\n3 5 0 0 0\n");
    std::string binary =
        "ply\r\nformat binary_big_endian 1.0\r\nelement vertex 3\r\nproperty double x\r\n"
        "property short y\r\nend_header\r\n";
    const std::string first = binary;
    const std::vector<std::string> vertices{std::string(10, '\0'), std::string("\x3F\xF0\0\0\0\0\0\0\0\0", 10),
                                            std::string("\x40\x59\0\0\0\0\0\0\0\0", 10)};
    for (const std::string& vertex : vertices) binary += vertex;
    std::string two = first;
    two.replace(two.find("vertex 3"), 8, "vertex 2");
    EXPECT_EQ(body_of(binary, {{"sites", "2"}}), two + vertices[1] + vertices[2]);
}

TEST(ChoiceFile, AnswersWithIndicesOfRows) {
    const std::vector<double> values{0, 0, 1, .1, 0, 2, 5, 0, 0};
    const std::string npy =
        npy_header("<f8", 3, 3) + std::string(reinterpret_cast<const char*>(values.data()), values.size() * 8);
    EXPECT_EQ(body_of(npy, {{"sites", "2"}, {"z", "1"}}), npy_header("<u4", 2, 1) + std::string("\1\0\0\0\2\0\0\0", 8));
    EXPECT_EQ(body_of(npy, {{"sites", "1"}, {"density", "2"}, {"z", "1"}, {"format", "csv"}}).substr(0, 9),
              "index,x,y");
    EXPECT_EQ(Json::parse(body_of("[[0,0],[1,1]]", {{"sites", "1"}})).at("sites"), 1);
    EXPECT_EQ(Json::parse(body_of(feature(3), {{"sites", "1"}}, "application/json")).at("indices"), Json({0}));
}

TEST(ChoiceFile, ReadsColumns) {
    const std::string csv = "X,Y,lon,w,k,p\n0,0,9,1,,1\n0.1,0,9,0,true,5\n5,0,9,1,0,0\n";
    const auto indices = [&](std::vector<TextOption> options) {
        options.insert(options.end(), {{"x", "X"}, {"y", "Y"}, {"format", "json"}});
        return Json::parse(body_of(csv, options)).at("indices");
    };
    EXPECT_EQ(indices({{"sites", "2"}, {"keep", "k"}}), Json({1, 2}));
    EXPECT_EQ(indices({{"sites", "2"}, {"density", "w"}}), Json({0, 2}));
    EXPECT_EQ(indices({{"sites", "2"}, {"priority", "p"}}), Json({1, 2}));
    const std::string map = "{\"type\":\"FeatureCollection\",\"features\":[" + feature(0, R"({"k":false})") + "," +
                            feature(1, R"({"k":true})") + "," + feature(9, "null") + "]}";
    EXPECT_EQ(Json::parse(body_of(map, {{"sites", "1"}, {"keep", "k"}, {"format", "json"}})).at("indices"), Json({1}));
}

TEST(ChoiceFile, ChoosesFromEachClass) {
    std::string csv = "x,y,kind\n";
    for (int i = 0; i < 90; ++i) csv += std::to_string(i) + ",0," + (i % 3 == 0 ? "a" : "\"b, c\"") + "\n";
    const auto number_of_a = [&](const std::string& sites) {
        const std::string body = body_of(csv, {{"sites", sites}, {"classes", "kind"}});
        return std::ranges::count(body, 'a');
    };
    EXPECT_EQ(number_of_a("30"), 10);
    EXPECT_EQ(number_of_a(R"({"a":4,"b, c":1})"), 4);
    EXPECT_EQ(error_of(csv, {{"sites", R"({"d":4})"}, {"classes", "kind"}}),
              "sites: there is no class 'd'; the classes are a, b, c");
    EXPECT_EQ(error_of(csv, {{"sites", R"({"a":31})"}, {"classes", "kind"}}),
              "sites: sites is 31 for the class 'a', which has only 30 candidates");
    EXPECT_EQ(error_of(csv, {{"sites", R"({"a":1})"}}), "sites: sites for each class need classes");
    EXPECT_EQ(error_of(csv, {{"sites", R"({"a":-1})"}, {"classes", "kind"}}).substr(0, 6), "sites:");
    EXPECT_EQ(error_of(csv, {{"sites", "3"}, {"classes", "sort"}}),
              "classes: there is no column 'sort'; the columns are x, y, kind");
}

TEST(ChoiceFile, ChoosesAsManyAsFit) {
    EXPECT_EQ(body_of("x,y\n0,0\n1,0\n2,0\n3,0\n4,0\n", {{"spacing", "2"}}), "x,y\n0,0\n2,0\n4,0\n");
    // A degree of latitude has 111 km.
    const std::string degrees = "lon,lat\n0,0\n0,1\n0,2\n";
    EXPECT_EQ(body_of(degrees, {{"spacing", "110000"}}), degrees);
    EXPECT_EQ(body_of(degrees, {{"spacing", "112000"}}), "lon,lat\n0,0\n0,2\n");
    EXPECT_EQ(error_of(degrees, {{"spacing", "1"}, {"sites", "2"}}),
              "spacing: spacing determines the number of sites, so both cannot be given");
    EXPECT_EQ(error_of(degrees, {{"spacing", "0"}}).substr(0, 8), "spacing:");
}

TEST(ChoiceFile, OrdersProgressively) {
    std::string csv = "x,y\n";
    for (int i = 0; i < 256; ++i) csv += std::to_string(i % 16) + "," + std::to_string(i / 16) + "\n";
    const Json points =
        Json::parse(body_of(csv, {{"sites", "256"}, {"order", "progressive"}, {"format", "json"}})).at("points");
    ASSERT_EQ(points.size(), 256);
    double least = 99;
    for (int i = 0; i < 16; ++i) {
        for (int j = 0; j < i; ++j)
            least = std::min(least, std::hypot(points[i][0].get<double>() - points[j][0].get<double>(),
                                               points[i][1].get<double>() - points[j][1].get<double>()));
    }
    EXPECT_GT(least, 2);  // 4 points of a square grid of 16 are 4 apart
}

TEST(ChoiceFile, NamesTheOptionTheRecordAndTheLimit) {
    const std::string csv = "x,y,name\n0,0,a\n1,,b\n";
    EXPECT_EQ(error_of("x,y\n", {}), "sites: sites is missing");
    EXPECT_EQ(error_of(csv, {{"sites", "1"}}), ": line 3: y must be a finite number, not ''");
    const std::string good = "x,y,name\n0,0,a\n1,2,b\n";
    EXPECT_EQ(error_of(good, {{"sites", "3"}}), "sites: sites is 3, but there are only 2 candidates");
    EXPECT_EQ(error_of(good, {{"sites", "1"}, {"density", "w"}}),
              "density: there is no column 'w'; the columns are x, y, name");
    EXPECT_EQ(error_of(good, {{"sites", "1"}, {"priority", "name"}}), "priority: line 2: name must be a number");
    EXPECT_EQ(error_of(good, {{"sites", "1"}, {"keep", "y"}}), "keep: line 3: y must be empty, 0, 1, true or false");
    EXPECT_EQ(error_of("lon,lat\n0,91\n", {{"sites", "1"}}),
              "coordinates: line 2 is not a longitude from -540 to 540 and a latitude from -90 to 90");
    EXPECT_EQ(error_of(feature(1) + "{\"a\":]}", {{"sites", "1"}}), ": the body is not valid JSON: error at byte 98");
    EXPECT_EQ(error_of(R"({"features":[{"type":"Feature","geometry":{"type":"MultiPoint","coordinates":[]}}]})",
                       {{"sites", "1"}}),
              ": /features/0 must have a single point, not 0");
    EXPECT_EQ(error_of(R"({"features":[{"a":1,"a":2}]})", {{"sites", "1"}}),
              ": a JSON object has the member 'a' twice");
}

}  // namespace
}  // namespace ccdt::api
