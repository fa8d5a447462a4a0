// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/surface_sample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "api/image/png_writer.h"
#include "api/image/srgb.h"
#include "api/operation/parsed_request.h"
#include "tests/support/mesh_files.h"
#include "tests/support/surfaces.h"

namespace ccdt::api {
namespace {

using Json = nlohmann::json;

/// Returns a decoder that yields the same triangles for any file.
Decode decode_to(const TriangleSoup& soup, const std::vector<std::string>& warnings = {}) {
    Decode decode;
    decode.surface = [=](std::string_view, const SurfaceHeader&, const std::stop_token&) {
        return Result<SurfaceContents>(SurfaceContents{soup, warnings});
    };
    return decode;
}

Result<Answer> answer(const TriangleSoup& soup, std::vector<TextOption> options, const Control& control = {},
                      const std::vector<std::string>& warnings = {}) {
    options.push_back({"sites", "50"});
    const auto request = parse_surface(SurfaceFile{}, options, "", {});
    if (!request) return tl::make_unexpected(request.error());
    Timings timings;
    return run_sample3(*request, decode_to(soup, warnings), control, timings);
}

Json json_of(const Result<Answer>& result) {
    EXPECT_TRUE(result) << result.error().message;
    return result ? Json::parse(result->body) : Json();
}

Control stopped() {
    std::stop_source source;
    source.request_stop();
    Control control;
    control.stop = source.get_token();
    return control;
}

TEST(SurfaceSample, PlacesTheRequestedNumberOfPoints) {
    const auto result = answer(test::sphere_surface(2), {});
    const Json json = json_of(result);
    EXPECT_EQ(json.at("points").size(), 50U);
    EXPECT_EQ(result->sites, 50U);
    EXPECT_FALSE(result->repeats);  // JSON contains the computing time
    EXPECT_TRUE(answer(test::sphere_surface(2), {{"format", "csv"}})->repeats);
}

TEST(SurfaceSample, FollowsDensitiesOfVertices) {
    const TriangleSoup square = test::square_surface(4);
    std::string density = "[";
    for (const Point3& vertex : square.vertices) density += (density.size() > 1 ? "," : "") + std::to_string(vertex.x);
    const Json json = json_of(answer(square, {{"density", density + ']'}}));
    double sum = 0;
    for (const Json& point : json.at("points")) sum += point.at(0).get<double>();
    EXPECT_NEAR(sum / 50, 2.0 / 3, 0.02);  // mean of x with a density of x
}

TEST(SurfaceSample, NamesTheDensityInErrors) {
    const auto wrong = answer(test::square_surface(1), {{"density", "[1]"}});
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().code, ErrorCode::Malformed);
    EXPECT_TRUE(wrong.error().field.starts_with("density")) << wrong.error().field;
    const auto plain = answer(test::square_surface(1), {{"density", "color"}});
    ASSERT_FALSE(plain);
    EXPECT_EQ(plain.error().code, ErrorCode::Unusable);
    EXPECT_EQ(plain.error().field, "density");
}

TEST(SurfaceSample, SortsPointsByRankInAProgressiveOrder) {
    const Json placed = json_of(answer(test::sphere_surface(2), {{"mesh", "true"}}));
    const Json ordered = json_of(answer(test::sphere_surface(2), {{"mesh", "true"}, {"order", "progressive"}}));
    EXPECT_NE(ordered.at("points"), placed.at("points"));
    EXPECT_EQ(std::set<Json>(ordered.at("points").begin(), ordered.at("points").end()),
              std::set<Json>(placed.at("points").begin(), placed.at("points").end()));
    for (std::size_t i = 0; i < 50; ++i) {
        EXPECT_EQ(ordered.at("rank").at(i), i);
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(ordered.at("mesh").at("vertices").at(i).at(k), ordered.at("points").at(i).at(k), 1e-9);
    }
}

TEST(SurfaceSample, IgnoresInvalidColoursAndTextureCoordinates) {
    TriangleSoup square = test::square_surface(1);
    square.colours.assign(square.vertices.size(), {0.5F, 2, 0});
    square.texture.assign(square.vertices.size(), {std::numeric_limits<float>::quiet_NaN(), 0});
    const Json json = json_of(answer(square, {}, {}, {"7 lines"}));
    EXPECT_FALSE(json.contains("colors"));
    EXPECT_FALSE(json.contains("texture"));
    ASSERT_EQ(json.at("warnings").size(), 3U);
    EXPECT_NE(json.at("warnings").at(2).at("detail").get<std::string>().find('7'), std::string::npos);
}

TEST(SurfaceSample, StopsOnRequest) {
    const auto result = answer(test::sphere_surface(2), {}, stopped());
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Stopped);
}

TEST(SurfaceSample, RefusesTrianglesWithoutArea) {
    const auto result = answer({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}}, {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
}

TEST(SampleRequest, RecognisesMeshes) {
    const std::string file = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    EXPECT_TRUE(parse_sample_request(file, {{"sites", "4"}}, "", {}));
    const auto broken = parse_sample_request("nothing", {{"sites", "4"}}, "", {}, "model/ply");
    ASSERT_FALSE(broken);
    EXPECT_EQ(broken.error().code, ErrorCode::Unusable);
    const auto many = parse_sample_request(file, {{"sites", "4"}}, "", {.max_faces = 0});
    ASSERT_FALSE(many);
    EXPECT_EQ(many.error().code, ErrorCode::LimitExceeded);
}

/// Answers a request for points on a mesh file.
Json sampled(const std::string& file, std::vector<TextOption> options, std::string* error = nullptr) {
    Timings timings;
    const auto result = parse_sample_request(file, options, "", {}).and_then([&](const ParsedPointer& request) {
        return request->run(decode_inline(), {}, timings, nullptr);
    });
    if (error != nullptr) *error = result ? "" : result.error().message;
    return error != nullptr && !result ? Json() : json_of(result);
}

/// Returns a PNG of a checker board in black and white.
/// @param cells  number of cells in each direction
std::string checker_png(int cells) {
    constexpr int kCell = 8;  // pixels
    std::vector<std::uint16_t> values;
    for (int i = 0; i < cells * kCell * cells * kCell; ++i)
        values.push_back((i / kCell + i / (cells * kCell * kCell)) % 2 == 0 ? 0 : 255);
    return *write_greys(values, cells * kCell, cells * kCell, 8);
}

/// Returns the share of points for which a function of their coordinates is true.
template <class Test>
double share_of(const Json& json, Test test) {
    double count = 0;
    for (const auto& p : json.at("points"))
        count += test(p.at(0).template get<double>(), p.at(1).template get<double>()) ? 1 : 0;
    return count / static_cast<double>(json.at("points").size());
}

TEST(SurfaceSample, FollowsAPictureInsideFaces) {
    const Json json = sampled(textured_glb(checker_png(4)), {{"sites", "2000"}, {"density", "color"}});
    // Between cells, the picture is interpolated linearly in light over the width of a pixel, so the border belongs to
    // both sides.
    const auto is_dark = [](double x, double y) {
        return (static_cast<int>(4 * x) + static_cast<int>(4 * y)) % 2 == 0;
    };
    EXPECT_GT(share_of(json, is_dark), 0.96);
    EXPECT_NEAR(share_of(json, [](double x, double) { return x < 0.5; }), 0.5, 0.01);
    double dark = 0;
    for (const auto& colour : json.at("colors")) dark += colour.at(0).get<int>() < 128 ? 1 : 0;
    EXPECT_GT(dark, 0.9 * 2000);
    EXPECT_EQ(json.at("faces").size(), 2000U);
}

TEST(SurfaceSample, PlacesPointsInProportionToTheDarknessOfAPicture) {
    std::vector<std::uint16_t> ramp(128);
    std::iota(ramp.begin(), ramp.end(), std::uint16_t{128});
    const Json json = sampled(textured_glb(*write_greys(ramp, 128, 1, 8), R"("wrapS":33071)"),
                              {{"sites", "2000"}, {"density", "color"}});
    const auto mass_until = [](int end) {
        double mass = 0;
        for (int x = 0; x < end; ++x) mass += 1 - to_linear(static_cast<unsigned char>(128 + x));
        return mass;
    };
    for (const int x : {16, 32, 64, 96})
        EXPECT_NEAR(share_of(json, [&](double at, double) { return at < x / 128.0; }), mass_until(x) / mass_until(128),
                    0.01);
}

TEST(SurfaceSample, RepeatsAPicture) {
    const std::string twice = R"(,"extensions":{"KHR_texture_transform":{"scale":[2,2]}})";
    const Json json = sampled(textured_glb(checker_png(2), "", twice), {{"sites", "1000"}, {"density", "color"}});
    EXPECT_GT(
        share_of(json, [](double x, double y) { return (static_cast<int>(4 * x) + static_cast<int>(4 * y)) % 2 == 0; }),
        0.94);
}

TEST(SurfaceSample, SaysWhyAMeshHasNoColours) {
    std::string error;
    const std::vector<TextOption> options = {{"sites", "10"}, {"density", "color"}};
    for (const std::string end : {"\n", "\r"}) {
        sampled("# no mtllib x" + end + "mtllib house.mtl" + end + "v 0 0 0" + end + "v 1 0 0" + end + "v 0 1 0" + end +
                    "f 1 2 3" + end,
                options, &error);
        EXPECT_EQ(error,
                  "the mesh has no colours: its materials are in another file (house.mtl); send a GLB, which holds "
                  "its textures");
    }
    const std::string linked = glb(textured_gltf(R"("uri":"wood.png")"), square_buffer() + std::string(32, '\0'));
    sampled(linked, options, &error);
    EXPECT_EQ(error,
              "the mesh has no colours: the texture wood.png is in another file; embed it, for example in a GLB");
    sampled(textured_glb("broken"), options, &error);
    EXPECT_NE(error.find("the embedded texture 0 cannot be read"), std::string::npos) << error;
    const Json json = sampled(linked, {{"sites", "10"}});
    EXPECT_NE(json.at("warnings").dump().find("wood.png"), std::string::npos);
}

}  // namespace
}  // namespace ccdt::api
