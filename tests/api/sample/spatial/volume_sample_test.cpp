// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/volume_sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "api/operation/parsed_request.h"
#include "api/output/npy_header.h"

namespace ccdt::api {
namespace {

using Json = nlohmann::json;

const std::string kTorus = R"("domain":{"type":"torus","width":2,"height":1,"depth":1})";
const std::string kBox = R"("domain":{"type":"box","width":2,"height":1,"depth":1})";

/// Returns an NPY file with an array of the shape (depth, height, width).
template <class Element>
std::string npy_of(std::string_view type, const std::array<std::size_t, 3>& shape, const std::vector<Element>& values) {
    std::string header = npy_header(type, shape[0], shape[1]);
    const std::string two = std::to_string(shape[0]) + ", " + std::to_string(shape[1]) + ')';
    const std::string three = two.substr(0, two.size() - 1) + ", " + std::to_string(shape[2]) + ')';
    header.replace(header.find(two), two.size(), three);
    header.erase(header.size() - 1 - (three.size() - two.size()), three.size() - two.size());  // padding
    return header + std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Element));
}

Result<Answer> answer(const std::string& body, const std::vector<TextOption>& options = {}, const Control& control = {},
                      const Limits& limits = {}) {
    const auto request = parse_sample_request(body, options, "", limits);
    if (!request) return tl::make_unexpected(request.error());
    Timings timings;
    return (*request)->run(decode_inline(), control, timings, nullptr);
}

Json json_of(const Result<Answer>& result) {
    EXPECT_TRUE(result) << result.error().message;
    return result ? Json::parse(result->body) : Json();
}

std::vector<Point3> points_of(const Json& list) {
    std::vector<Point3> points;
    for (const Json& p : list) points.push_back({p.at(0), p.at(1), p.at(2)});
    return points;
}

/// Returns the sum of the volumes of tetrahedra, or 0 if one of them has no positive volume.
double volume_of(const std::vector<Point3>& vertices, const std::vector<std::array<std::size_t, 4>>& tetrahedra) {
    double sum = 0;
    for (const auto& [a, b, c, d] : tetrahedra) {
        const Point3 u = vertices[b] - vertices[a], v = vertices[c] - vertices[a], w = vertices[d] - vertices[a];
        if (dot(cross(u, v), w) <= 0) return 0;
        sum += dot(cross(u, v), w) / 6;
    }
    return sum;
}

template <class Value>
Value take(std::string_view& bytes) {
    Value value;
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes.remove_prefix(sizeof value);
    return value;
}

TEST(VolumeSample, PlacesTheRequestedPointsInTheDomain) {
    const Json json = json_of(answer("{\"sites\":50,\"seed\":7,\"quality\":\"draft\"," + kBox + '}'));
    ASSERT_EQ(json.at("points").size(), 50U);
    for (const auto& [x, y, z] : points_of(json.at("points")))
        EXPECT_TRUE(x > 0 && x < 2 && y > 0 && y < 1 && z > 0 && z < 1);
    EXPECT_EQ(json.at("sites"), 50);
    EXPECT_EQ(json.at("seed"), 7);
    EXPECT_EQ(json.at("quality"), "draft");
    EXPECT_FALSE(json.contains("mesh"));
}

TEST(VolumeSample, ReadsVoxelsOfAllTypesInTheirOrder) {
    // The density is 0 except in one voxel: the last in x, the first in y, the middle one in z.
    const std::size_t where = (1 * 2 + 0) * 4 + 3;
    const auto check = [&](std::string_view type, auto one) {
        std::vector<decltype(one)> values(std::size_t{3} * 2 * 4);
        values[where] = one;
        const Json json = json_of(answer(npy_of(type, {3, 2, 4}, values), {{"sites", "9"}}));
        ASSERT_EQ(json.at("points").size(), 9U) << type;
        for (const auto& [x, y, z] : points_of(json.at("points")))
            EXPECT_TRUE(x >= 3 && x <= 4 && y >= 0 && y <= 1 && z >= 1 && z <= 2) << type;
    };
    check("|b1", std::uint8_t{1});
    check("|i1", std::int8_t{5});
    check("<u2", std::uint16_t{500});
    check("<i4", std::int32_t{70'000});
    check("<u8", std::uint64_t{1} << 60);
    check("<f4", 0.5F);
    check("<f8", 1e-300);
    const std::string json = R"({"sites":9,"domain":{"type":"box","width":4,"height":2,"depth":3},)"
                             R"("density":{"width":4,"height":1,"depth":1,"values":[0,0,0,2]}})";
    const Json placed = json_of(answer(json));
    for (const auto& [x, y, z] : points_of(placed.at("points"))) EXPECT_GE(x, 3);
}

TEST(VolumeSample, TakesTheSidesFromOptionsOrFromVoxels) {
    const std::string voxels = npy_of<float>("<f4", {1, 1, 2}, {1, 1});
    const auto reach = [&](const std::vector<TextOption>& more) {
        std::vector<TextOption> options = {{"sites", "200"}, {"quality", "draft"}};
        options.insert(options.end(), more.begin(), more.end());
        Point3 most;
        for (const Point3& p : points_of(json_of(answer(voxels, options)).at("points")))
            most = {std::max(most.x, p.x), std::max(most.y, p.y), std::max(most.z, p.z)};
        return most;
    };
    const Point3 whole = reach({}), wide = reach({{"domain", "torus"}, {"width", "20"}, {"depth", "5"}});
    EXPECT_TRUE(whole.x > 1.7 && whole.x < 2 && whole.z > 0.7 && whole.z < 1);
    EXPECT_TRUE(wide.x > 17 && wide.x < 20 && wide.y < 1 && wide.z > 4 && wide.z < 5);
    const Point3 object = reach({{"domain", R"({"type":"box","width":3,"height":3,"depth":3})"}});
    EXPECT_TRUE(object.x > 2.5 && object.y > 2.5 && object.z > 2.5);
}

TEST(VolumeSample, WritesTheSamePointsInAllFormats) {
    const std::string request = "{\"sites\":60,\"quality\":\"draft\"," + kTorus;
    const auto points = points_of(json_of(answer(request + '}')).at("points"));
    const auto file = [&](const std::string& format) {
        return answer(request + ",\"format\":\"" + format + "\"}")->body;
    };
    std::string csv = "x,y,z\r\n";
    for (const auto& [x, y, z] : points) {
        for (const double ordinate : {x, y, z}) csv += Json(ordinate).dump() + (ordinate == z ? "\r\n" : ",");
    }
    EXPECT_EQ(file("csv").size(), csv.size());
    const std::string bytes(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(Point3));
    EXPECT_EQ(file("npy"), npy_header("<f8", 60, 3) + bytes);
    EXPECT_TRUE(file("ply").ends_with("property double z\nend_header\n" + bytes));
    EXPECT_NE(file("vtu").find(bytes), std::string::npos);
}

TEST(VolumeSample, WritesTetrahedraThatFillTheDomain) {
    for (const std::string& domain : {kBox, kTorus}) {
        const std::string request = "{\"sites\":200,\"mesh\":true,\"quality\":\"draft\"," + domain;
        const Json mesh = json_of(answer(request + '}')).at("mesh");
        const std::size_t count = mesh.at("tetrahedra").size();
        if (domain == kBox) {
            EXPECT_NEAR(volume_of(points_of(mesh.at("vertices")), mesh.at("tetrahedra")), 2, 1e-9);
        }
        const auto file = answer(request + ",\"format\":\"msh\"}");
        ASSERT_TRUE(file);
        std::string_view rest(file->body);
        const auto skip = [&](std::string_view section) { rest.remove_prefix(rest.find(section) + section.size()); };
        skip("$MeshFormat\n4.1 1 8\n");
        EXPECT_EQ(take<std::int32_t>(rest), 1);
        skip("$Nodes\n");
        using Totals = std::array<std::uint64_t, 4>;
        const auto nodes = take<Totals>(rest)[1];
        EXPECT_EQ((take<std::array<std::int32_t, 3>>(rest)), (std::array<std::int32_t, 3>{3, 1, 0}));
        EXPECT_EQ(take<std::uint64_t>(rest), nodes);
        for (std::uint64_t i = 1; i <= nodes; ++i) EXPECT_EQ(take<std::uint64_t>(rest), i);
        std::vector<Point3> vertices;
        for (std::uint64_t i = 0; i < nodes; ++i) vertices.push_back(take<Point3>(rest));
        skip("$EndNodes\n$Elements\n");
        EXPECT_EQ(take<Totals>(rest)[1], count);
        EXPECT_EQ((take<std::array<std::int32_t, 3>>(rest)), (std::array<std::int32_t, 3>{3, 1, 4}));
        EXPECT_EQ(take<std::uint64_t>(rest), count);
        std::vector<std::array<std::size_t, 4>> tetrahedra;
        for (std::uint64_t i = 0; i < count; ++i) {
            EXPECT_EQ(take<std::uint64_t>(rest), i + 1);
            tetrahedra.push_back(take<std::array<std::size_t, 4>>(rest));
            for (std::size_t& vertex : tetrahedra.back()) --vertex;
        }
        EXPECT_EQ(rest, "\n$EndElements\n");
        EXPECT_NEAR(volume_of(vertices, tetrahedra), 2, 1e-9) << domain;
    }
}

TEST(VolumeSample, SortsPointsByRankInAProgressiveOrder) {
    const std::string request = "{\"sites\":80,\"mesh\":true,\"quality\":\"draft\"," + kBox;
    const Json placed = json_of(answer(request + '}')),
               ordered = json_of(answer(request + R"(,"order":"progressive"})"));
    EXPECT_FALSE(placed.contains("rank"));
    EXPECT_TRUE(ordered.at("points") != placed.at("points"));
    const auto set_of = [](const Json& list) { return std::set<Json>(list.begin(), list.end()); };
    EXPECT_TRUE(set_of(ordered.at("points")) == set_of(placed.at("points")));
    EXPECT_TRUE(set_of(ordered.at("mesh").at("vertices")) == set_of(placed.at("mesh").at("vertices")));
    for (std::size_t i = 0; i < 80; ++i) {
        EXPECT_EQ(ordered.at("rank").at(i), i);
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(ordered.at("mesh").at("vertices").at(i).at(k), ordered.at("points").at(i).at(k), 0.2);
    }
    EXPECT_NEAR(volume_of(points_of(ordered.at("mesh").at("vertices")), ordered.at("mesh").at("tetrahedra")), 2, 1e-9);
}

TEST(VolumeSample, RefusesToUnwrapATorusWithTooFewPoints) {
    const std::string request = "{\"sites\":2,\"mesh\":true," + kTorus;
    EXPECT_TRUE(answer(request + '}'));
    const auto refused = answer(request + R"(,"format":"vtu"})");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Unusable);
    EXPECT_EQ(refused.error().field, "/format");
}

/// A cube with the sides 2 and the centre (5, 5, 5), without some of its faces.
std::string cube_file(std::size_t missing = 0) {
    const std::vector<std::string> faces = {"4 0 2 3 1\n", "4 4 5 7 6\n", "4 0 1 5 4\n",
                                            "4 2 6 7 3\n", "4 0 4 6 2\n", "4 1 3 7 5\n"};
    std::string file = "OFF\n8 " + std::to_string(faces.size() - missing) + " 0\n";
    for (int i = 0; i < 8; ++i) {
        const auto position = [](int bit) { return bit != 0 ? "6" : "4"; };
        file.append(position(i & 1))
            .append(" ")
            .append(position(i & 2))
            .append(" ")
            .append(position(i & 4))
            .append("\n");
    }
    for (std::size_t i = missing; i < faces.size(); ++i) file += faces[i];
    return file;
}

TEST(VolumeSample, PlacesPointsInsideMeshes) {
    const std::string voxels = npy_of<float>("<f4", {1, 1, 2}, {0, 1});
    const Json json = json_of(answer(cube_file(), {{"sites", "60"},
                                                   {"domain", "solid"},
                                                   {"fixed", "[[5.5,5,5]]"},
                                                   {"order", "progressive"},
                                                   {"density", voxels}}));
    ASSERT_EQ(json.at("points").size(), 60U);
    for (const Point3& p : points_of(json.at("points"))) {
        EXPECT_TRUE(p.x >= 5 && p.x < 6 && p.y > 4 && p.y < 6 && p.z > 4 && p.z < 6);
        EXPECT_GT(length(p - Point3{5.5, 5, 5}), 0.2);
    }
    EXPECT_EQ(json.at("rank").at(59), 59);
    EXPECT_TRUE(answer(cube_file(), {{"sites", "6"}, {"domain", "surface"}}));
}

TEST(VolumeSample, NamesTheFieldOfErrors) {
    struct Case {
        std::string body;
        std::vector<TextOption> options;
        ErrorCode code;
        std::string field;
    };
    const auto json = [](const std::string& members) { return "{\"sites\":9," + members + '}'; };
    const auto box = [&](const std::string& width) {
        return json(R"("domain":{"type":"box","height":1,"depth":1,"width":)" + width + '}');
    };
    const auto nan = std::numeric_limits<double>::quiet_NaN();
    const std::string voxels = npy_of<double>("<f8", {1, 1, 2}, {1, 2});
    const std::vector<TextOption> sites = {{"sites", "9"}};
    const std::vector<Case> cases = {
        {"{" + kBox + '}', {}, ErrorCode::Malformed, "/sites"},
        {box("0"), {}, ErrorCode::Malformed, "/domain/width"},
        {box("-1"), {}, ErrorCode::Malformed, "/domain/width"},
        {box("1e-308"), {}, ErrorCode::Malformed, "/domain"},
        {box("1,\"x\":1"), {}, ErrorCode::Malformed, "/domain/x"},
        {json(R"("domain":{"type":"box","width":1})"), {}, ErrorCode::Malformed, "/domain"},
        {json(R"("domain":"torus","width":1,"height":1)"), {}, ErrorCode::Malformed, "/domain"},
        {json(kBox + R"(,"depth":1)"), {}, ErrorCode::Malformed, "/domain"},
        {json(kBox + R"(,"crease":45)"), {}, ErrorCode::Malformed, "/crease"},
        {json(kBox + R"(,"fixed":[[1,0.5,0.5],[1,2,0.5]])"), {}, ErrorCode::Malformed, "/fixed/1"},
        {json(kBox + R"(,"fixed":[[1,0.5]])"), {}, ErrorCode::Malformed, "/fixed/0"},
        {json(kBox + R"(,"quality":"stealthy")"), {}, ErrorCode::Malformed, "/quality"},
        {json(kTorus + R"(,"quality":"stealthy")"), {}, ErrorCode::Malformed, "/quality"},
        {json(kBox + R"(,"format":"msh")"), {}, ErrorCode::Malformed, "/mesh"},
        {json(kBox + R"(,"format":"stl")"), {}, ErrorCode::Malformed, "/format"},
        {json(kBox + R"(,"order":"path")"), {}, ErrorCode::Malformed, "/order"},
        {json(kBox + R"(,"density":{"width":2,"height":1,"depth":1,"values":[1]})"),
         {},
         ErrorCode::Malformed,
         "/density/values"},
        {json(kBox + R"(,"density":{"width":2,"height":1,"depth":1,"values":[0,0]})"),
         {},
         ErrorCode::Unusable,
         "/density"},
        {json(kBox), {{"seed", "1"}}, ErrorCode::Malformed, "seed"},
        {voxels, {}, ErrorCode::Malformed, "sites"},
        {cube_file(1), {{"sites", "9"}, {"domain", "solid"}}, ErrorCode::Unusable, ""},
        {cube_file(), {{"sites", "9"}, {"domain", "box"}}, ErrorCode::Malformed, "domain"},
        {cube_file(), {{"sites", "9"}, {"domain", "solid"}, {"depth", "2"}}, ErrorCode::Malformed, "domain"},
        {cube_file(), {{"sites", "9"}, {"domain", "solid"}, {"fixed", "[[0,0,0]]"}}, ErrorCode::Malformed, "fixed/0"},
        {cube_file(), {{"sites", "9"}, {"domain", "solid"}, {"quality", "stealthy"}}, ErrorCode::Malformed, "quality"},
        {voxels, {{"sites", "9"}, {"domain", "solid"}}, ErrorCode::Malformed, "domain"},
        {voxels, {{"sites", "9"}, {"domain", "ball"}}, ErrorCode::Malformed, "domain"},
        {voxels, {{"sites", "9"}, {"width", "0"}}, ErrorCode::Malformed, "width"},
        {voxels, {{"sites", "9"}, {"crease", "45"}}, ErrorCode::Malformed, "crease"},
        {voxels, {{"sites", "9"}, {"fixed", "[[9,0,0]]"}}, ErrorCode::Malformed, "fixed/0"},
        {voxels, {{"sites", "32"}, {"quality", "stealthy"}, {"domain", "torus"}}, ErrorCode::Malformed, "quality"},
        {voxels, {{"sites", "9"}, {"domain", "{"}}, ErrorCode::Malformed, "domain"},
        {cube_file(), {{"sites", "9"}, {"domain", "solid"}, {"density", "{"}}, ErrorCode::Malformed, "density"},
        {voxels, {{"sites", "9"}, {"density", voxels}}, ErrorCode::Malformed, "density"},
        {npy_of<double>("<f8", {1, 1, 2}, {1, nan}), sites, ErrorCode::Malformed, "density/1"},
        {npy_of<double>("<f8", {1, 1, 2}, {1, -1}), sites, ErrorCode::Malformed, "density/1"},
        {npy_of<double>("<f8", {1, 1, 2}, {0, 0}), sites, ErrorCode::Unusable, "density"},
        {npy_of<double>("<c8", {1, 1, 2}, {1, 1}), sites, ErrorCode::Malformed, ""},
        {npy_of<double>("<f8", {1, 0, 2}, {}), sites, ErrorCode::Malformed, ""},
        {npy_header("<f8", 1, 1) + std::string(8, '\0'), sites, ErrorCode::Malformed, ""},
    };
    for (const auto& [body, options, code, field] : cases) {
        const auto result = answer(body, options);
        ASSERT_FALSE(result) << body << ' ' << field;
        EXPECT_EQ(result.error().code, code) << result.error().message;
        EXPECT_EQ(result.error().field, field) << result.error().message;
    }
    const auto surface = answer(cube_file(), {{"sites", "9"}, {"density", voxels}});
    ASSERT_FALSE(surface);
    EXPECT_NE(surface.error().message.find("needs domain=solid"), std::string::npos) << surface.error().message;
    const auto message = [](const Result<Answer>& result) { return result ? "" : result.error().message; };
    EXPECT_EQ(message(answer(json(R"("domain":"solid")"))), "domain solid needs a mesh");
    EXPECT_EQ(message(answer(voxels, {{"sites", "9"}, {"domain", R"({"type":"box","width":0})"}})),
              "domain/width must be a number above 0");
    EXPECT_EQ(message(answer(voxels, {{"sites", "9"}, {"domain", "{x"}})), "domain is not valid JSON: error at byte 2");
    const auto many = answer(voxels, sites, {}, {.max_pixels = 1});
    ASSERT_FALSE(many);
    EXPECT_EQ(many.error().code, ErrorCode::LimitExceeded);
}

TEST(VolumeSample, ChecksDomainsAndVoxelsBeforeItRuns) {
    const auto field = [](const std::string& body, const std::vector<TextOption>& options = {}) {
        const auto request = parse_sample_request(body, options, "", {});
        return request ? "accepted" : request.error().field;
    };
    const auto json = [](const std::string& members) { return "{\"sites\":32," + members + '}'; };
    const std::vector<TextOption> torus = {{"sites", "32"}, {"domain", "torus"}, {"quality", "stealthy"}};
    EXPECT_EQ(field(json(kBox + R"(,"density":{"width":1,"height":1,"depth":2,"values":[0,0]})")), "/density");
    EXPECT_EQ(field(json(kBox + R"(,"fixed":[[0,0,9]])")), "/fixed/0");
    EXPECT_EQ(field(json(R"("domain":{"type":"box","width":1,"height":1,"depth":1e-301})")), "/domain");
    EXPECT_EQ(field(npy_of<float>("<f4", {1, 1, 2}, {0, 0}), torus), "density");
    EXPECT_EQ(field(npy_of<float>("<f4", {1, 1, 2}, {1, -1}), torus), "density/1");
    EXPECT_EQ(field(npy_of<float>("<f4", {1, 1, 2}, {1, 2}), torus), "quality");
    EXPECT_EQ(field(npy_of<float>("<f4", {1, 1, 2}, {2, 2}), torus), "accepted");
}

TEST(VolumeSample, TakesTheSidesOfAWordInJson) {
    const auto points = [](const std::string& domain) {
        return json_of(answer("{\"sites\":20,\"quality\":\"draft\"," + domain + '}')).at("points");
    };
    EXPECT_EQ(points(R"("domain":"torus","width":2,"height":1,"depth":1)"), points(kTorus));
    EXPECT_EQ(points(R"("domain":"box","width":2,"height":1,"depth":1)"), points(kBox));
    const std::string voxels = R"("density":{"width":2,"height":1,"depth":1,"values":[1,1]},)";
    EXPECT_EQ(points(voxels + R"("domain":"box")"), points(voxels + kBox));
}

TEST(VolumeSample, TakesEqualVoxelsForAUniformDensity) {
    const std::vector<TextOption> options = {{"sites", "32"}, {"quality", "stealthy"}, {"domain", "torus"}};
    const Json json = json_of(answer(npy_of<double>("<f8", {1, 1, 2}, {3, 3}), options));
    EXPECT_EQ(json.at("points"),
              json_of(answer("{\"sites\":32,\"quality\":\"stealthy\"," + kTorus + '}')).at("points"));
}

TEST(VolumeSample, PutsEdgesOfTetrahedraAlongCreases) {
    const auto vertices = [](const std::string& crease) {
        return json_of(answer(cube_file(), {{"sites", "30"}, {"domain", "solid"}, {"mesh", "1"}, {"crease", crease}}))
            .at("mesh")
            .at("vertices");
    };
    EXPECT_EQ(vertices("45"), vertices("89"));
    EXPECT_NE(vertices("45"), vertices("91"));
}

TEST(VolumeSample, AcceptsExtremeSidesAndFewSites) {
    const auto cube = [](const std::string& side) {
        return R"("width":)" + side + R"(,"height":)" + side + R"(,"depth":)" + side;
    };
    for (const auto* side : {"1e-301", "1e-308", "5e-324"}) {
        EXPECT_EQ(answer(R"({"sites":1,"domain":{"type":"box",)" + cube(side) + "}}").error().message,
                  "the sides must be finite and at least 1e-300");
    }
    for (const auto* side : {"1e-300", "1e308"}) {
        for (const auto* type : {"box", "torus"}) {
            for (const auto* sites : {"1", "30"}) {
                const std::string body = R"({"order":"progressive","sites":)" + std::string(sites) +
                                         R"(,"domain":{"type":")" + type + "\"," + cube(side) + "}}";
                const Json json = json_of(answer(body));
                for (const auto& [x, y, z] : points_of(json.at("points"))) {
                    const double limit = Json::parse(side);
                    EXPECT_TRUE(x >= 0 && x <= limit && y >= 0 && y <= limit && z >= 0 && z <= limit) << body;
                }
            }
        }
    }
}

TEST(VolumeSample, AnswersPartiallyOrNotAtAllAfterAStop) {
    const std::string request = "{\"sites\":50,\"mesh\":true," + kBox;
    const auto stopped = [&](const std::string& options) {
        std::stop_source source;
        Control control;
        control.stop = source.get_token();
        control.progress = [&](const Progress&) { source.request_stop(); };  // once all points are placed
        return answer(request + options + '}', {}, control);
    };
    const auto refused = stopped("");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Stopped);
    const auto partial = stopped(R"(,"on_deadline":"partial")");
    EXPECT_EQ(json_of(partial).at("points").size(), 50U);
    EXPECT_TRUE(partial->partial);
}

}  // namespace
}  // namespace ccdt::api
