// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/surface_formats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace ccdt::api {
namespace {

using Json = nlohmann::json;

/// Returns points on a square of two triangles at z = 5, with red and black vertices.
PlacedSurface square(bool extras = true, double at = 0) {
    TriangleSoup soup;
    soup.vertices = {{at, 0, 5}, {at + 2, 0, 5}, {at + 2, 2, 5}, {at, 2, 5}};
    soup.triangles = {{0, 1, 2}, {0, 2, 3}};
    if (extras) {
        soup.colours = {{1, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
        soup.texture = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    }
    auto made = Surface::create(soup, {}).value();
    SurfaceDistribution dots;
    dots.points = {{0, {0.5, 0.25, 0.25}}, {1, {0.25, 0.25, 0.5}}, {0, {0.25, 0.5, 0.25}}};
    dots.iterations = 5;
    dots.trace = {0.5, 0.125};
    dots.mesh = SurfaceMesh{{{at, 0, 5}, {at + 2, 0, 5}, {at + 2, 2, 5}}, {{0, 1, 2}}};
    if (extras) dots.ranks = {0, 1, 2};
    return {std::move(soup), std::move(made.surface), {}, {}, std::move(dots), 7, 1.5};
}

const SurfacePointFormat& format_named(std::string_view name) {
    const auto formats = surface_formats();
    return **std::ranges::find(formats, name, [](const SurfacePointFormat* each) { return each->file.name; });
}

std::string written(std::string_view format, const PlacedSurface& placed, bool mesh = false) {
    Body body;
    const auto result = format_named(format).writer(mesh)(placed, body, {});
    EXPECT_TRUE(result) << result.error().message;
    return std::move(body.text());
}

/// Reads a value at an offset of a binary file.
template <class Value>
Value value_at(const std::string& file, std::size_t offset) {
    Value value{};
    EXPECT_LE(offset + sizeof value, file.size());
    if (offset + sizeof value <= file.size()) std::memcpy(&value, file.data() + offset, sizeof value);
    return value;
}

std::vector<float> floats_at(const std::string& file, std::size_t offset, std::size_t count) {
    std::vector<float> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back(value_at<float>(file, offset + i * sizeof(float)));
    return values;
}

TEST(SurfaceCsv, HasARowForEachPoint) {
    // A quarter of red light is 137 in sRGB, half of it 188.
    EXPECT_EQ(written("csv", square()),
              "x,y,z,face,u,v,w,nx,ny,nz,r,g,b,s,t,rank\r\n"
              "1,0.5,5,0,0.5,0.25,0.25,0,0,1,188,0,0,0.5,0.25,0\r\n"
              "0.5,1.5,5,1,0.25,0.25,0.5,0,0,1,137,0,0,0.25,0.75,1\r\n"
              "1.5,0.5,5,0,0.25,0.5,0.25,0,0,1,137,0,0,0.75,0.25,2\r\n");
    EXPECT_TRUE(written("csv", square(false)).starts_with("x,y,z,face,u,v,w,nx,ny,nz\r\n1,0.5,5,0,"));
}

TEST(SurfaceCsv, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    Body body;
    ASSERT_TRUE(format_named("csv").writer(false)(square(false), body, source.get_token()));
    EXPECT_EQ(body.text(), "x,y,z,face,u,v,w,nx,ny,nz\r\n");
}

TEST(SurfaceNpy, HasTheColumnsOfCsv) {
    const std::string file = written("npy", square());
    EXPECT_NE(file.find("'shape': (3, 16)"), std::string::npos);
    const std::size_t data = file.size() - 3 * 16 * sizeof(double);
    EXPECT_EQ(value_at<double>(file, data), 1);
    EXPECT_EQ(value_at<double>(file, data + 16 * 8 + 3 * 8), 1);         // face of the second point
    EXPECT_EQ(value_at<double>(file, data + 2 * 16 * 8 + 10 * 8), 137);  // red of the third point
}

TEST(SurfaceJson, HasAListForEachProperty) {
    const Json json = Json::parse(written("json", square()));
    EXPECT_EQ(json.at("points"), Json::parse("[[1,0.5,5],[0.5,1.5,5],[1.5,0.5,5]]"));
    EXPECT_EQ(json.at("faces"), Json::parse("[0,1,0]"));
    EXPECT_EQ(json.at("barycentric"), Json::parse("[[0.5,0.25,0.25],[0.25,0.25,0.5],[0.25,0.5,0.25]]"));
    EXPECT_EQ(json.at("normals"), Json::parse("[[0,0,1],[0,0,1],[0,0,1]]"));
    EXPECT_EQ(json.at("colors"), Json::parse("[[188,0,0],[137,0,0],[137,0,0]]"));
    EXPECT_EQ(json.at("texture"), Json::parse("[[0.5,0.25],[0.25,0.75],[0.75,0.25]]"));
    EXPECT_EQ(json.at("rank"), Json::parse("[0,1,2]"));
    EXPECT_EQ(json.at("mesh"), Json::parse(R"({"vertices":[[0,0,5],[2,0,5],[2,2,5]],"triangles":[[0,1,2]]})"));
    EXPECT_EQ(json.at("sites"), 3);
    EXPECT_EQ(json.at("seed"), 7);
    EXPECT_EQ(json.at("iterations"), 5);
    EXPECT_EQ(json.at("variation"), 0.125);
    EXPECT_EQ(json.at("trace").size(), 2U);
    EXPECT_EQ(json.at("elapsed_ms"), 1.5);
    EXPECT_EQ(json.size(), 14U);
}

TEST(SurfaceJson, OmitsAbsentProperties) {
    PlacedSurface placed = square(false);
    placed.dots.mesh.reset();
    placed.dots.stopped = true;
    placed.repairs = {{"2 triangles were turned over", 2, 1}};
    placed.warnings = {{"the \xc3\xa4 mesh", 0}};
    const Json json = Json::parse(written("json", placed));
    for (const auto* name : {"colors", "texture", "rank", "mesh"}) EXPECT_FALSE(json.contains(name)) << name;
    EXPECT_EQ(json.at("partial"), true);
    EXPECT_EQ(json.at("repaired"), Json::parse(R"([{"pointer":"","detail":"2 triangles were turned over","face":1}])"));
    EXPECT_EQ(json.at("warnings").at(0).at("detail"), "the \xc3\xa4 mesh");
    EXPECT_FALSE(json.at("warnings").at(0).contains("face"));
}

TEST(SurfacePly, HasTheDeclaredProperties) {
    const std::string file = written("ply", square());
    const std::string header =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\n"
        "property double x\nproperty double y\nproperty double z\n"
        "property uint face\n"
        "property float barycentric_u\nproperty float barycentric_v\nproperty float barycentric_w\n"
        "property float nx\nproperty float ny\nproperty float nz\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property float s\nproperty float t\nproperty uint rank\nend_header\n";
    constexpr std::size_t kRow = 24 + 12 + 3 + 8 + 4 + 12 + 4;
    ASSERT_TRUE(file.starts_with(header)) << file.substr(0, header.size());
    ASSERT_EQ(file.size(), header.size() + 3 * kRow);
    const std::size_t second = header.size() + kRow;
    EXPECT_EQ(value_at<double>(file, second + 8), 1.5);
    EXPECT_EQ(value_at<std::uint32_t>(file, second + 24), 1U);
    EXPECT_EQ(floats_at(file, second + 28, 6), (std::vector<float>{0.25F, 0.25F, 0.5F, 0, 0, 1}));
    EXPECT_EQ(value_at<std::uint8_t>(file, second + 52), 137);
    EXPECT_EQ(floats_at(file, second + 55, 2), (std::vector<float>{0.25F, 0.75F}));
    EXPECT_EQ(value_at<std::uint32_t>(file, second + 63), 1U);
}

TEST(SurfacePly, HasTheTriangulationOnRequest) {
    const std::string file = written("ply", square(), true);
    const std::string header =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\n"
        "property double x\nproperty double y\nproperty double z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n";
    ASSERT_TRUE(file.starts_with(header));
    ASSERT_EQ(file.size(), header.size() + 3 * 24 + 13);
    EXPECT_EQ(value_at<double>(file, header.size() + 24), 2);
    EXPECT_EQ(value_at<std::uint8_t>(file, header.size() + 72), 3);
    EXPECT_EQ(value_at<std::uint32_t>(file, header.size() + 73 + 8), 2U);
}

/// The chunks of a GLB file.
struct Glb {
    Json json;
    std::string content;

    /// Returns the floats of the array that an attribute names.
    std::vector<float> floats(std::size_t accessor) const {
        const Json& view = json.at("bufferViews").at(accessor);
        const std::size_t size = view.at("byteLength");
        return floats_at(content, view.at("byteOffset"), size / sizeof(float));
    }
};

Glb parse_glb(const std::string& file) {
    EXPECT_EQ(file.substr(0, 4), "glTF");
    EXPECT_EQ(value_at<std::uint32_t>(file, 4), 2U);
    EXPECT_EQ(value_at<std::uint32_t>(file, 8), file.size());
    const auto length = value_at<std::uint32_t>(file, 12);
    EXPECT_EQ(length % 4, 0U);
    EXPECT_EQ(file.substr(16, 4), "JSON");
    EXPECT_EQ(file.substr(24 + length, 4), std::string("BIN\0", 4));
    Glb glb{Json::parse(file.substr(20, length)), file.substr(28 + length)};
    EXPECT_EQ(value_at<std::uint32_t>(file, 20 + length), glb.content.size());
    EXPECT_EQ(glb.json.at("buffers").at(0).at("byteLength"), glb.content.size());
    return glb;
}

TEST(SurfaceGlb, HasAnAttributeForEachProperty) {
    const Glb glb = parse_glb(written("glb", square()));
    const Json& primitive = glb.json.at("meshes").at(0).at("primitives").at(0);
    EXPECT_EQ(primitive.at("mode"), 0);
    EXPECT_EQ(primitive.at("attributes"),
              Json::parse(R"({"POSITION":0,"NORMAL":1,"COLOR_0":2,"TEXCOORD_0":3,"_FACE":4,"_BARYCENTRIC":5})"));
    EXPECT_EQ(glb.json.at("accessors").at(0).at("min"), Json::parse("[0.5,0.5,5]"));
    EXPECT_EQ(glb.json.at("accessors").at(0).at("max"), Json::parse("[1.5,1.5,5]"));
    for (const Json& accessor : glb.json.at("accessors")) EXPECT_EQ(accessor.at("count"), 3);
    EXPECT_EQ(glb.floats(0), (std::vector<float>{1, 0.5F, 5, 0.5F, 1.5F, 5, 1.5F, 0.5F, 5}));
    EXPECT_EQ(glb.floats(2), (std::vector<float>{0.5F, 0, 0, 0.25F, 0, 0, 0.25F, 0, 0}));
    EXPECT_EQ(glb.floats(3), (std::vector<float>{0.5F, 0.25F, 0.25F, 0.75F, 0.75F, 0.25F}));
    EXPECT_EQ(glb.floats(4), (std::vector<float>{0, 1, 0}));
    EXPECT_EQ(glb.floats(5), (std::vector<float>{0.5F, 0.25F, 0.25F, 0.25F, 0.25F, 0.5F, 0.25F, 0.5F, 0.25F}));
    EXPECT_FALSE(glb.json.at("nodes").at(0).contains("translation"));
}

TEST(SurfaceGlb, HasTheTriangulationOnRequest) {
    const Glb glb = parse_glb(written("glb", square(), true));
    const Json& primitive = glb.json.at("meshes").at(0).at("primitives").at(0);
    EXPECT_EQ(primitive.at("mode"), 4);
    EXPECT_EQ(primitive.at("indices"), 1);
    EXPECT_EQ(glb.json.at("accessors").at(1).at("count"), 3);
    EXPECT_EQ(glb.json.at("accessors").at(1).at("componentType"), 5125);
    EXPECT_EQ(value_at<std::uint32_t>(glb.content, 36 + 8), 2U);
}

TEST(SurfaceGlb, KeepsPrecisionFarFromTheOrigin) {
    constexpr double kFar = 1 << 26;
    const Glb glb = parse_glb(written("glb", square(false, kFar)));
    const Json translation = glb.json.at("nodes").at(0).at("translation");
    const std::vector<float> positions = glb.floats(0);
    EXPECT_EQ(translation.at(0).get<double>() + static_cast<double>(positions[0]), kFar + 1);
    EXPECT_EQ(translation.at(0).get<double>() + static_cast<double>(positions[3]), kFar + 0.5);
}

TEST(SurfaceObj, ListsVerticesAndTriangles) {
    EXPECT_EQ(written("obj", square(), true), "v 0 0 5\nv 2 0 5\nv 2 2 5\nf 1 2 3\n");
}

TEST(SurfaceStl, HasNormalsAndCorners) {
    const std::string file = written("stl", square(), true);
    ASSERT_EQ(file.size(), 84U + 50U);
    EXPECT_FALSE(file.starts_with("solid"));
    EXPECT_EQ(value_at<std::uint32_t>(file, 80), 1U);
    EXPECT_EQ(floats_at(file, 84, 12), (std::vector<float>{0, 0, 1, 0, 0, 5, 2, 0, 5, 2, 2, 5}));
    EXPECT_EQ(value_at<std::uint16_t>(file, 84 + 48), 0U);
}

TEST(SurfaceFormats, RefuseCoordinatesBeyondTheRangeOfFloats) {
    const PlacedSurface placed = [] {
        PlacedSurface far = square(false);
        for (Point3& vertex : far.soup.vertices) vertex = 1e200 * vertex;
        for (Point3& vertex : far.dots.mesh->vertices) vertex = 1e200 * vertex;
        return far;
    }();
    const std::vector<std::pair<std::string, bool>> cases = {{"glb", false}, {"glb", true}, {"stl", true}};
    for (const auto& [format, mesh] : cases) {
        Body body;
        const auto result = format_named(format).writer(mesh)(placed, body, {});
        ASSERT_FALSE(result) << format;
        EXPECT_EQ(result.error().code, ErrorCode::Unusable);
        EXPECT_EQ(result.error().field, "format");
    }
    EXPECT_NE(written("csv", placed).find("1e+200"), std::string::npos);
}

TEST(SurfaceFormats, TakeAtLeastTheDocumentedBytes) {
    const PlacedSurface placed = square(false);
    for (const SurfacePointFormat* format : surface_formats()) {
        const bool mesh = format->writer(false) == nullptr;
        EXPECT_GE(written(format->file.name, placed, mesh).size(), format->least * placed.size()) << format->file.name;
    }
}

}  // namespace
}  // namespace ccdt::api
