// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/surface_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "api/decode/decode.h"
#include "api/image/image_codec.h"
#include "api/image/png_writer.h"
#include "api/image/srgb.h"
#include "tests/api/files.h"
#include "tests/support/mesh_files.h"

namespace ccdt::api {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Triangles = std::vector<Triangle>;

Result<SurfaceContents> read(std::string_view bytes, std::size_t max_pixels = 10'000) {
    const auto format = recognise_surface(bytes);
    if (!format) return failure(ErrorCode::Unsupported, "not recognised");
    return read_surface_header(bytes, *format, 100'000, max_pixels).and_then([&](const SurfaceHeader& header) {
        return read_surface_with_pictures(bytes, header);
    });
}

/// Returns the positions of the corners of all triangles, in their order.
std::vector<Point3> corners_of(const TriangleSoup& soup) {
    std::vector<Point3> corners;
    for (const auto& triangle : soup.triangles) {
        for (const std::uint32_t corner : triangle) corners.push_back(soup.vertices.at(corner));
    }
    return corners;
}

double area_of(const TriangleSoup& soup) {
    const auto corners = corners_of(soup);
    double area = 0;
    for (std::size_t i = 0; i < corners.size(); i += 3)
        area += length(cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i])) / 2;
    return area;
}

/// Returns files with the square [0, 1]^2 in the plane z = 0 as two triangles, one in each variant of each format.
std::vector<std::string> squares() {
    const std::string ply_vertices = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string ply_faces = "element face 2\nproperty list uchar ushort vertex_indices\nend_header\n";
    std::string big = "ply\nformat binary_big_endian 1.0\n" + ply_vertices + ply_faces;
    std::string little = "ply\nformat binary_little_endian 1.0\n" + ply_vertices + ply_faces;
    const std::string buffer = square_buffer();
    little += buffer.substr(0, 48);
    for (std::size_t i = 0; i < 48; i += 4) big += {buffer[i + 3], buffer[i + 2], buffer[i + 1], buffer[i]};
    for (std::size_t i = 48; i < 60; i += 2) {
        const std::string count = (i - 48) % 6 == 0 ? "\3" : "";
        little += count + buffer[i] + buffer[i + 1];
        big += count + buffer[i + 1] + buffer[i];
    }
    const std::string facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
    return {
        "solid square\n" + facet + "vertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n" + facet +
            "vertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid square\n",
        binary_stl({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0}),
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf -4 -2 -1\n",
        "ply\nformat ascii 1.0\n" + ply_vertices + ply_faces + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
        little,
        big,
        "OFF 4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3 255 0 0\n",
        square_gltf(R"([{"mesh":0}])", R"(,"uri":"data:application/octet-stream;base64,)" + base64(buffer) + '"'),
        glb(square_gltf(), buffer),
    };
}

TEST(SurfaceReader, ReadsTheSameTrianglesFromAllFormats) {
    const std::vector<Point3> expected{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (const std::string& file : squares()) {
        const auto contents = read(file);
        ASSERT_TRUE(contents) << contents.error().message;
        EXPECT_EQ(corners_of(contents->soup), expected) << file.substr(0, 30);
        EXPECT_EQ(contents->warnings, std::vector<std::string>());
        EXPECT_TRUE(contents->soup.colours.empty());
        EXPECT_TRUE(contents->soup.texture.empty());
    }
}

TEST(SurfaceReader, SurvivesTruncationAtEveryByte) {
    for (const std::string& file : squares()) {
        for (std::size_t size = 0; size < file.size(); ++size) {
            if (const auto contents = read(std::string_view(file).substr(0, size)); contents) {
                ASSERT_LE(contents->soup.triangles.size(), 2U);
                for (const auto& triangle : contents->soup.triangles)
                    ASSERT_LT(*std::ranges::max_element(triangle), contents->soup.vertices.size());
            } else {
                ASSERT_FALSE(contents.error().message.empty());
            }
        }
    }
}

TEST(SurfaceReader, KeepsTheOrderOfFacesInGroupsAndMaterials) {
    const std::string file =
        "mtllib /etc/passwd\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 2 3\no b\n  usemtl blue\nf 1 3 "
        "4\n"
        "o a\nusemtl red\nf 1 4 2\ng x y\ns 1\nf 2 3 4\n";
    const std::vector<Point3> v{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const auto end : std::to_array<std::string_view>({"\n", "\r\n", "\r", "\f", {"\0", 1}})) {
        std::string text;
        for (const char c : file) c == '\n' ? text += end : text += c;
        const auto contents = read(text);
        ASSERT_TRUE(contents) << contents.error().message;
        EXPECT_EQ(corners_of(contents->soup),
                  (std::vector{v[0], v[1], v[2], v[0], v[2], v[3], v[0], v[3], v[1], v[1], v[2], v[3]}));
    }
}

TEST(SurfaceReader, JoinsTheSolidsOfAnStl) {
    const std::string loop = "outer loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    const auto contents = read("solid a\nfacet normal 0 0 1\n" + loop + "endsolid a\nsolid empty\nendsolid empty\n" +
                               "solid c\nfacet normal 0 0 1\n" + loop + "endsolid c\n");
    ASSERT_TRUE(contents) << contents.error().message;
    EXPECT_EQ(contents->soup.triangles.size(), 2U);
}

TEST(SurfaceReader, DividesConcavePolygons) {
    // An arrow head with the area 1, and a star with many corners.
    const auto arrow = read("v 0 0 0\nv 2 1 0\nv 0 2 0\nv 1 1 0\nf 1 2 3 4\n");
    ASSERT_TRUE(arrow) << arrow.error().message;
    EXPECT_EQ(arrow->soup.triangles.size(), 2U);
    EXPECT_NEAR(area_of(arrow->soup), 1, 1e-6);
    for (const int corners : {10, 100, 1000}) {
        std::string vertices, face = std::to_string(corners);
        double area = 0;
        const auto radius = [](int i) { return i % 2 == 0 ? 1.0 : 0.5; };
        const double angle = 2 * std::acos(-1.0) / corners;
        for (int i = 0; i < corners; ++i) {
            vertices += std::to_string(radius(i) * std::cos(i * angle)) + ' ' +
                        std::to_string(radius(i) * std::sin(i * angle)) + " 0\n";
            face += ' ' + std::to_string(i);
            area += radius(i) * radius(i + 1) * std::sin(angle) / 2;
        }
        const auto star = read("OFF\n" + std::to_string(corners) + " 1 0\n" + vertices + face + '\n');
        ASSERT_TRUE(star) << star.error().message;
        EXPECT_EQ(star->soup.triangles.size(), static_cast<std::size_t>(corners - 2));
        EXPECT_NEAR(area_of(star->soup), area, 1e-4);
    }
}

TEST(SurfaceReader, RefusesPolygonsWithTooManyCorners) {
    std::string file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
    for (int i = 0; i < 10'001; ++i) file += " 1";
    EXPECT_EQ(read(file).error().message,
              "OBJ file cannot be read: face 0 (line 4) has more than 10000 corners, the limit");
}

TEST(SurfaceReader, ConvertsColoursToLinearLight) {
    const std::string vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const float grey = 0.21586F;  // linear light of the sRGB value 128
    const std::string files[] = {
        "ply\nformat ascii 1.0\n" + vertices + "property uchar red\nproperty uchar green\nproperty uchar blue\n" +
            faces + "0 0 0 255 128 0\n1 0 0 255 128 0\n0 1 0 255 128 0\n3 0 1 2\n",
        "v 0 0 0 1 0.50196 0\nv 1 0 0 1 0.50196 0\nv 0 1 0 1 0.50196 0\nf 1 2 3\n",
        "COFF\n3 1 0\n0 0 0 255 128 0 255\n1 0 0 255 128 0 255\n0 1 0 255 128 0 255\n3 0 1 2\n",
        "COFF\n3\t1\t0\n0.5 0 0 255 128 0 255\n1.5 0 0 255 128 0 255\n0.5 1 0 255 128 0 255\n3 0 1 2\n",
        "COFF\n3 1 0\n0 0 0 1.0 .50196 0\n1 0 0 1.0 .50196 0\n0 1 0 1.0 .50196 0\n3 0 1 2\n",
    };
    for (const std::string& file : files) {
        const auto contents = read(file);
        ASSERT_TRUE(contents) << contents.error().message;
        ASSERT_EQ(contents->soup.colours.size(), 3U) << file;
        for (const auto& colour : contents->soup.colours) {
            EXPECT_FLOAT_EQ(colour[0], 1);
            EXPECT_NEAR(colour[1], grey, 1e-4);
            EXPECT_FLOAT_EQ(colour[2], 0);
        }
    }
}

TEST(SurfaceReader, KeepsLinearColoursAndTextureCoordinatesOfGltf) {
    std::string buffer = square_buffer();
    for (int i = 0; i < 4; ++i) {
        for (const float value : {0.5F, 0.25F, 2.0F}) append_bytes(buffer, value);
    }
    for (int i = 0; i < 4; ++i) {
        for (const float value : {0.25F, 0.75F}) append_bytes(buffer, value);
    }
    std::string json = square_gltf();
    const auto insert = [&json](std::string_view before, std::string_view text) {
        json.insert(json.find(before), text);
    };
    insert("},\"indices\"", R"(,"COLOR_0":2,"TEXCOORD_0":3)");
    insert("],\"bufferViews\"", R"(,{"bufferView":2,"componentType":5126,"count":4,"type":"VEC3"},)"
                                R"({"bufferView":3,"componentType":5126,"count":4,"type":"VEC2"})");
    insert("],\"buffers\"", R"(,{"buffer":0,"byteOffset":60,"byteLength":48},)"
                            R"({"buffer":0,"byteOffset":108,"byteLength":32})");
    json.replace(json.find("\"byteLength\":60}"), 15, "\"byteLength\":140");
    const auto contents = read(glb(json, buffer));
    ASSERT_TRUE(contents) << contents.error().message;
    ASSERT_EQ(contents->soup.colours.size(), 4U);
    ASSERT_EQ(contents->soup.texture.size(), 4U);
    EXPECT_EQ(contents->soup.colours[3], (std::array<float, 3>{0.5F, 0.25F, 1.0F}));
    EXPECT_EQ(contents->soup.texture[3], (std::array<float, 2>{0.25F, 0.75F}));
}

/// Returns a PNG with rows of the given grey values.
std::string grey_png(const std::vector<std::uint16_t>& values, int width) {
    return *write_greys(values, width, static_cast<int>(values.size()) / width, 8);
}

std::vector<std::uint8_t> reds_of(const TriangleSoup& soup) {
    std::vector<std::uint8_t> reds;
    for (const auto& texel : soup.texels) reds.push_back(texel[0]);
    return reds;
}

TEST(SurfaceReader, ReadsEmbeddedPictures) {
    const std::string png = grey_png({1, 2, 128, 253, 254, 255}, 3);
    std::string buffer = square_buffer() + std::string(32, '\0');
    const std::string uri = R"("uri":"data:image/png;base64,)" + base64(png) + '"';
    std::string json = textured_gltf(uri);
    json.replace(json.find("\"byteLength\":92"), 15,
                 R"("byteLength":92,"uri":"data:application/octet-stream;base64,)" + base64(buffer) + '"');
    // The picture is in a buffer that is encoded in base64, at an offset that is not a multiple of 3.
    std::string in_buffer = textured_gltf(R"("bufferView":3,"mimeType":"image/png")");
    buffer += png;
    in_buffer.insert(in_buffer.find("],\"buffers\""),
                     R"(,{"buffer":0,"byteOffset":92,"byteLength":)" + std::to_string(png.size()) + '}');
    in_buffer.replace(in_buffer.find("\"byteLength\":92"), 15,
                      "\"byteLength\":" + std::to_string(buffer.size()) +
                          R"(,"uri":"data:application/octet-stream;base64,)" + base64(buffer) + '"');
    for (const std::string& file : {textured_glb(png), json, in_buffer}) {
        const auto contents = read(file);
        ASSERT_TRUE(contents) << contents.error().message;
        const TriangleSoup& soup = contents->soup;
        EXPECT_EQ(contents->picture_error, "");
        ASSERT_EQ(soup.materials.size(), 1U);
        EXPECT_EQ(soup.material_of, (std::vector<std::uint32_t>{0, 0}));
        EXPECT_EQ(soup.materials[0].width, 3U);
        EXPECT_EQ(soup.materials[0].height, 2U);
        EXPECT_EQ(soup.materials[0].wrap, (std::array{Wrap::Repeat, Wrap::Repeat}));
        EXPECT_EQ(reds_of(soup), (std::vector<std::uint8_t>{1, 2, 128, 253, 254, 255}));
    }
    const auto header = *read_surface_header(in_buffer, SurfaceFormat::Gltf, 100, 100);
    EXPECT_EQ(header.texels, 6U);
    EXPECT_TRUE(read(textured_glb(png), 0)->soup.materials.empty());
}

TEST(SurfaceReader, DecodesPicturesLikeOtherImages) {
    const std::string jpeg = fixture("grey.jpg");
    const auto picture = *decode_colour_image(jpeg, 10'000);
    const auto contents = read(textured_glb(jpeg));
    ASSERT_TRUE(contents) << contents.error().message;
    const auto reds = reds_of(contents->soup);
    ASSERT_EQ(reds.size(), picture.red.size());
    for (std::size_t i = 0; i < reds.size(); ++i) ASSERT_EQ(reds[i], to_srgb(static_cast<double>(picture.red[i]))) << i;
}

TEST(SurfaceReader, ReadsFactorsAndTransformsOfMaterials) {
    // Wrapping modes, a quarter turn, and a factor.
    const auto contents = read(textured_glb(
        grey_png({0, 64, 128, 255}, 2), R"("wrapS":33071,"wrapT":33648)",
        R"(,"extensions":{"KHR_texture_transform":{"offset":[0.25,0.5],"rotation":1.5707963,"scale":[2,3]}})",
        R"(,"alphaMode":"MASK","alphaCutoff":0.25)"));
    ASSERT_TRUE(contents) << contents.error().message;
    const Material& material = contents->soup.materials.at(0);
    EXPECT_EQ(material.wrap, (std::array{Wrap::Clamp, Wrap::Mirror}));
    EXPECT_EQ(material.alpha, AlphaMode::Mask);
    EXPECT_EQ(material.cutoff, 0.25F);
    // (s, t) -> (3 t + 0.25, -2 s + 0.5), by the specification of the extension.
    const std::array<float, 6> expected{0, 3, 0.25F, -2, 0, 0.5F};
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(material.transform[i], expected[i], 1e-5) << i;

    std::string json = square_gltf();
    json.insert(json.find("}]}],\"accessors\""), R"(,"material":0)");
    json.insert(json.size() - 1, R"(,"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.25,0.5,2,0.5]}}])");
    const auto plain = read(glb(json, square_buffer()));
    ASSERT_TRUE(plain) << plain.error().message;
    EXPECT_EQ(plain->soup.materials.at(0).factor, (std::array{0.25F, 0.5F, 1.0F, 0.5F}));
    EXPECT_FALSE(read(glb(square_gltf(), square_buffer()))->soup.has_colours());
}

TEST(SurfaceReader, ReportsPicturesThatCannotBeRead) {
    const auto error = [](const std::string& file, std::size_t max_pixels = 100) {
        const auto contents = read(file, max_pixels);
        EXPECT_TRUE(contents) << contents.error().message;
        return contents ? contents->picture_error : "";
    };
    const std::string png = grey_png({0, 64, 128, 255}, 2);
    EXPECT_EQ(error(textured_glb(png.substr(0, png.size() - 20))),
              "the embedded texture 0 cannot be read: the image is broken or truncated");
    EXPECT_EQ(error(textured_glb("no picture")).substr(0, 39), "the embedded texture 0 cannot be read: ");
    EXPECT_EQ(
        error(textured_glb(png), 3),
        "the embedded texture 0 cannot be read: the image has 2 x 2 pixels; this server's limit (max-pixels) is 3");
    EXPECT_EQ(error(glb(textured_gltf(R"("uri":"wood%20planks.png")"), square_buffer() + std::string(32, '\0'))),
              "the texture wood%20planks.png is in another file; embed it, for example in a GLB");
    EXPECT_EQ(error(glb(textured_gltf(R"("uri":"data:image/png;base64,")"), square_buffer() + std::string(32, '\0'))),
              "the picture of a texture has no bytes");
    std::string without_coordinates = textured_glb(png);
    without_coordinates.replace(without_coordinates.find("TEXCOORD_0"), 10, "_COORDINAT");
    EXPECT_EQ(error(without_coordinates), "a part of the mesh has a texture, but not its coordinates TEXCOORD_0");
}

TEST(SurfaceReader, ReadsTextureCoordinatesOfObj) {
    const auto contents = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0.5\nvt 0 1\nf 1/1 2/2 3/3\n");
    ASSERT_TRUE(contents) << contents.error().message;
    EXPECT_EQ(contents->soup.texture, (std::vector<std::array<float, 2>>{{0, 0.25F}, {1, 0.5F}, {0, 1}}));
}

TEST(SurfaceReader, AppliesTheTransformationsOfNodes) {
    // The first instance is scaled and moved; the second one is reflected as well, and keeps its orientation.
    const auto contents = read(glb(square_gltf(R"([{"translation":[10,0,0],"children":[1,2]},)"
                                               R"({"mesh":0,"scale":[2,2,2]},)"
                                               R"({"mesh":0,"matrix":[-1,0,0,0,0,1,0,0,0,0,1,0,0,0,5,1]}])"),
                                   square_buffer()));
    ASSERT_TRUE(contents) << contents.error().message;
    const auto corners = corners_of(contents->soup);
    ASSERT_EQ(corners.size(), 12U);
    EXPECT_EQ(corners[1], (Point3{12, 0, 0}));
    EXPECT_EQ(corners[2], (Point3{12, 2, 0}));
    EXPECT_EQ(corners[6], (Point3{10, 0, 5}));
    for (std::size_t i = 0; i < corners.size(); i += 3)
        EXPECT_GT(cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]).z, 0) << i;
}

TEST(SurfaceReader, IgnoresPointsAndLines) {
    const auto contents = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\np 1\n");
    ASSERT_TRUE(contents) << contents.error().message;
    EXPECT_EQ(contents->soup.triangles.size(), 1U);
    EXPECT_EQ(contents->warnings,
              std::vector<std::string>{"points and lines, which have no area, are ignored: 2; the first is line 4"});
}

TEST(SurfaceReader, RefusesIndicesOutOfRange) {
    const std::string vertices =
        "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    std::string buffer = square_buffer();
    buffer[58] = 9;
    const std::string files[] = {
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n",
        "ply\nformat ascii 1.0\n" + vertices + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
        "ply\nformat ascii 1.0\n" + vertices + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
        "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2 1000000000\n",
        glb(square_gltf(), buffer),
    };
    for (const std::string& file : files) {
        const auto contents = read(file);
        ASSERT_FALSE(contents) << file;
        EXPECT_EQ(contents.error().code, ErrorCode::Unusable);
    }
}

TEST(SurfaceReader, KeepsDegenerateFaces) {
    const auto contents = read("OFF\n3 4 0\n0 0 0\n1 0 0\n0 1 0\n3 0 0 0\n3 0 1 2\n2 0 1\n3 2 1 0\n");
    ASSERT_TRUE(contents) << contents.error().message;
    EXPECT_EQ(contents->soup.triangles, (Triangles{{0, 0, 0}, {0, 1, 2}, {2, 1, 0}}));
    EXPECT_EQ(
        contents->warnings,
        std::vector<std::string>{"faces with fewer than three corners are ignored: 1; the first is face 2 (line 8)"});
}

TEST(SurfaceReader, OpensNoOtherFiles) {
    const std::string path = testing::TempDir() + "ccdt-square.bin";
    std::ofstream(path, std::ios::binary) << square_buffer();
    const SurfaceHeader header{SurfaceFormat::Gltf, 1000, 3000};
    const auto contents = read_surface(square_gltf(R"([{"mesh":0}])", R"(,"uri":")" + path + '"'), header);
    std::filesystem::remove(path);
    ASSERT_FALSE(contents);
    EXPECT_NE(contents.error().message.find("in another file"), std::string::npos) << contents.error().message;
}

TEST(SurfaceReader, RefusesCornersThatAreNotFinite) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(read(binary_stl({0, 0, 0, 1, 0, nan, 0, 0, 1})).error().message,
              "STL file cannot be read: vertex 1 is not finite, in triangle 0");
    const std::string off = "OFF 4 1 0\n0 0 0\n1 0 0\n0 1 0\n-nan(ind) 1e999 1.#INF\n3 0 1 ";
    EXPECT_EQ(read(off + "3\n").error().message,
              "OFF file cannot be read: vertex 3 (line 5) is not finite, in triangle 0");
    EXPECT_TRUE(read(off + "2\n"));  // no face uses the vertex
}

TEST(SurfaceReader, RefusesPicturesThatAreSentAsMeshes) {
    const std::string png = "\x89PNG\r\n\x1A\n" + std::string(200, 'x');
    using enum SurfaceFormat;
    for (const SurfaceFormat format : {StlText, StlBinary, Obj, Ply, Off, Gltf, Glb}) {
        const SurfaceHeader header{format, 1000, 3000};
        EXPECT_FALSE(read_surface_header(png, format, 1000)) << name_of(format);
        const auto contents = read_surface(png, header);
        ASSERT_FALSE(contents) << name_of(format);
        EXPECT_EQ(contents.error().code, ErrorCode::Unusable);
    }
}

}  // namespace
}  // namespace ccdt::api
