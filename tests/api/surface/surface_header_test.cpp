// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/surface_header.h"

#include <gtest/gtest.h>

#include <string>

#include "api/image/png_writer.h"
#include "api/text/base64.h"
#include "tests/support/mesh_files.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kMaxFaces = 1000;

Result<SurfaceHeader> header_of(std::string_view bytes) {
    const auto format = recognise_surface(bytes);
    if (!format) return failure(ErrorCode::Unsupported, "not recognised");
    return read_surface_header(bytes, *format, kMaxFaces);
}

void expect_refused(std::string_view bytes, std::string_view reason, ErrorCode code = ErrorCode::Unusable) {
    const auto header = header_of(bytes);
    ASSERT_FALSE(header) << reason;
    EXPECT_EQ(header.error().code, code);
    EXPECT_NE(header.error().message.find(reason), std::string::npos) << header.error().message;
}

std::string ply_with(std::string_view elements, std::string_view data = "", std::string_view format = "ascii") {
    return "ply\nformat " + std::string(format) + " 1.0\n" + std::string(elements) + "end_header\n" + std::string(data);
}

TEST(SurfaceHeader, RecognisesFormatsByContent) {
    EXPECT_EQ(recognise_surface("solid a\nfacet normal 0 0 1\n"), SurfaceFormat::StlText);
    EXPECT_EQ(recognise_surface(binary_stl(std::vector<float>(9))), SurfaceFormat::StlBinary);
    EXPECT_EQ(recognise_surface("# a comment\n\r\n v 0 0 0\n"), SurfaceFormat::Obj);
    EXPECT_EQ(recognise_surface("\xEF\xBB\xBFmtllib a.mtl\n"), SurfaceFormat::Obj);
    EXPECT_EQ(recognise_surface("ply\nformat ascii 1.0\n"), SurfaceFormat::Ply);
    EXPECT_EQ(recognise_surface("OFF\n3 1 0\n"), SurfaceFormat::Off);
    EXPECT_EQ(recognise_surface("# a comment\nSTCNOFF 3 1 0\n"), SurfaceFormat::Off);
    EXPECT_EQ(recognise_surface(square_gltf()), SurfaceFormat::Gltf);
    EXPECT_EQ(recognise_surface(glb(square_gltf(), square_buffer())), SurfaceFormat::Glb);
}

TEST(SurfaceHeader, PrefersTheSizeOfABinaryStlToItsFirstWord) {
    std::string file = binary_stl(std::vector<float>(9));
    file.replace(0, 5, "solid");
    EXPECT_EQ(recognise_surface(file), SurfaceFormat::StlBinary);
}

TEST(SurfaceHeader, RecognisesNoMeshInOtherFiles) {
    EXPECT_EQ(recognise_surface(""), std::nullopt);
    EXPECT_EQ(recognise_surface("\x89PNG\r\n\x1A\n"), std::nullopt);
    EXPECT_EQ(recognise_surface("x,y,z\n0,0,0\n"), std::nullopt);
    EXPECT_EQ(recognise_surface(R"({"domain":{"type":"rectangle"},"sites":10})"), std::nullopt);
    EXPECT_EQ(recognise_surface(R"({"type":"Feature","properties":{"asset":"pipe","accessors":2}})"), std::nullopt);
}

TEST(SurfaceHeader, UsesTheMediaTypeOfAFileThatIsNotRecognised) {
    EXPECT_EQ(recognise_surface("damaged", "model/stl"), SurfaceFormat::StlBinary);
    EXPECT_EQ(recognise_surface("damaged", "model/gltf-binary"), SurfaceFormat::Glb);
    EXPECT_EQ(recognise_surface("damaged", "text/plain"), std::nullopt);
    EXPECT_EQ(recognise_surface("OFF 1 2 3", "model/stl"), SurfaceFormat::Off);
}

TEST(SurfaceHeader, CountsTrianglesAndVertices) {
    struct Case {
        std::string file;
        std::uint64_t triangles, vertices;
    };
    const std::string ply =
        "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\n";
    const Case cases[] = {
        {binary_stl(std::vector<float>(18)), 2, 6},
        {"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n", 1, 3},
        {"v 0 0 0\nf 1 2 3 4\r\nf 1/1 2/2 3/3\nl 1 2\n", 3, 7},
        {"f 1 2 \\\n3 4 \\\n5\nf 1 2 3", 4, 8},
        {ply_with(ply, "0 0 0 1 0 0 1 1 0 0 1 0\n4 0 1 2 3\n"), 2, 4},
        {ply_with(ply, std::string(48, '\0') + '\4' + std::string(16, '\0'), "binary_little_endian"), 2, 4},
        {"OFF\n# a comment\n4 1 4\n0 0 0\n1 0 0 # first\n1 1 0\n0 1 0\n4 0 1 2 3\n", 2, 4},
        {square_gltf(), 2, 4},
        {square_gltf(R"([{"children":[1,2]},{"mesh":0},{"mesh":0}])"), 4, 8},
    };
    for (const auto& [file, triangles, vertices] : cases) {
        const auto header = header_of(file);
        ASSERT_TRUE(header) << file << header.error().message;
        EXPECT_EQ(header->max_triangles, triangles) << file;
        EXPECT_EQ(header->max_vertices, vertices) << file;
        EXPECT_GT(header->decoder_bytes, std::uint64_t{1} << 20) << file;
    }
}

TEST(SurfaceHeader, RefusesMoreFacesThanTheLimit) {
    expect_refused(binary_stl(std::vector<float>(9 * (kMaxFaces + 1))), "limit (max-faces) is 1000",
                   ErrorCode::LimitExceeded);
    std::string obj = "v 0 0 0\n";
    for (std::size_t i = 0; i < kMaxFaces; ++i) obj += "f 1 1 1\n";
    EXPECT_TRUE(header_of(obj));
    expect_refused(obj + "f 1 1 1\n", "max-faces", ErrorCode::LimitExceeded);
    std::string nodes = R"([{"mesh":0,"children":[)";
    for (std::size_t i = 1; i <= kMaxFaces; ++i) nodes += (i > 1 ? "," : "") + std::to_string(i);
    nodes += "]}";
    for (std::size_t i = 1; i <= kMaxFaces; ++i) nodes += R"(,{"mesh":0})";
    expect_refused(square_gltf(nodes + "]"), "max-faces", ErrorCode::LimitExceeded);
}

TEST(SurfaceHeader, RefusesCountsThatTheFileCannotHold) {
    std::string stl = binary_stl(std::vector<float>(9));
    stl.resize(stl.size() - 1);
    EXPECT_EQ(read_surface_header(stl, SurfaceFormat::StlBinary, kMaxFaces).error().message,
              "STL file cannot be read: its header announces 1 facets, which need 134 bytes, but the file has 133");
    EXPECT_FALSE(read_surface_header("", SurfaceFormat::StlBinary, kMaxFaces));
    expect_refused(
        ply_with(
            "element vertex 4294967295\nproperty float x\nproperty float y\nproperty float z\nelement face 4294967295\n"
            "property list uchar int vertex_indices\n",
            "0 0 0\n"),
        "vertex 1 of 4294967295 is incomplete, because the file ends");
    expect_refused(ply_with("element vertex 4294967296\n"),
                   "the number of elements is not an integer below 4294967296");
    expect_refused("ply\nformat ascii 1.0\n", "its header has no end");
    expect_refused("OFF 4294967295 4294967295 0\n0 0 0\n", "line 3: vertex 1 is incomplete, because the file ends");
    expect_refused("OFF\nBINARY\n", "binary OFF is not supported");
    expect_refused("OFF", "the numbers of vertices and faces do not follow the keyword");
}

TEST(SurfaceHeader, ReportsDamageRatherThanLimits) {
    std::string faces;
    for (std::size_t i = 0; i <= kMaxFaces; ++i) faces += "3 0 1 2\n";
    const std::string vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string elements =
        vertices + "element face " + std::to_string(kMaxFaces + 1) + "\nproperty list uchar int vertex_indices\n";
    const std::string data = "0 0 0 1 0 0 0 1 0\n" + faces;
    expect_refused(ply_with(elements, data), "max-faces", ErrorCode::LimitExceeded);
    expect_refused(ply_with(elements, data + "7"), "there is \"7\" after the last element");
    expect_refused(ply_with(elements, data.substr(0, data.size() - 2)), "face 1000 of 1001 is incomplete");
    std::string off = "OFF 3 " + std::to_string(kMaxFaces + 1) + " 0\n0 0 0\n1 0 0\n0 1 0\n" + faces;
    expect_refused(off, "max-faces", ErrorCode::LimitExceeded);
    expect_refused(off + "3 0 1 2\n", "there is \"3\" after the last face");
    // Faces of fewer than three corners have no triangles, and do not hide those of others.
    EXPECT_EQ(header_of(ply_with(vertices + "element face 3\nproperty list uchar int vertex_indices\n",
                                 "0 0 0 1 0 0 0 1 0 1 0 3 0 1 2 2 0 1\n"))
                  ->max_triangles,
              1U);
}

TEST(SurfaceHeader, EstimatesLittleMemoryForManyInstancesAndMaterials) {
    constexpr std::size_t kNodes = 10'000;
    std::string nodes = R"([{"children":[1)";
    for (std::size_t i = 2; i <= kNodes; ++i) nodes += ',' + std::to_string(i);
    nodes += "]}";
    for (std::size_t i = 1; i <= kNodes; ++i) nodes += R"(,{"mesh":0})";
    std::string json = square_gltf(nodes + ']');
    json.insert(json.size() - 1, R"(,"materials":[{})");
    for (int i = 1; i < 3000; ++i) json.insert(json.size() - 1, ",{}");
    json.insert(json.size() - 1, "]");
    const auto header = read_surface_header(glb(json, square_buffer()), SurfaceFormat::Glb, 100'000);
    ASSERT_TRUE(header) << header.error().message;
    EXPECT_EQ(header->max_triangles, 2 * kNodes);
    EXPECT_EQ(header->max_materials, 3001U);
    EXPECT_LT(header->decoder_bytes, std::uint64_t{64} << 20);
}

TEST(SurfaceHeader, LimitsTheElementsOfPly) {
    std::string elements;
    for (int i = 0; i <= 100; ++i) elements += "element e" + std::to_string(i) + " 0\n";
    expect_refused(ply_with(elements), "line 103: there are more than 100 elements, the limit");
    std::string properties = "element vertex 0\n";
    for (int i = 0; i <= 1000; ++i) properties += "property float p" + std::to_string(i) + '\n';
    expect_refused(ply_with(properties), "line 1004: there are more than 1000 properties, the limit");
}

TEST(SurfaceHeader, RefusesFacesWithoutCorners) {
    expect_refused(ply_with("element face 1\nproperty list int int corners\n", "3 0 0 0\n"),
                   "its faces have no list vertex_indices");
}

TEST(SurfaceHeader, RefusesFilesWithoutTriangles) {
    for (const char* file : {"solid a\nendsolid a\n", "v 0 0 0\np 1\nl 1 1\n", "OFF 0 0 0\n"})
        expect_refused(file, "it has no triangles or polygons");
    expect_refused(binary_stl({}), "it has no triangles or polygons");
    expect_refused(ply_with("element face 1\nproperty list int int vertex_indices\n", "2 0 0\n"),
                   "it has no triangles or polygons");
    expect_refused(square_gltf("[{}]"), "its scene has no meshes");
}

TEST(SurfaceHeader, RefusesDamagedGltfFiles) {
    const std::string file = glb(square_gltf(), square_buffer());
    for (std::size_t size = 4; size < file.size(); ++size)
        ASSERT_FALSE(read_surface_header(file.substr(0, size), SurfaceFormat::Glb, kMaxFaces)) << size;
    std::string old = file;
    old[4] = 1;
    expect_refused(old, "its version is 1; only version 2 is supported");
    std::string version = square_gltf();
    version.replace(version.find("2.0"), 3, "1.0");
    expect_refused(version, "only glTF 2 is supported");
    expect_refused(square_gltf(R"([{"mesh":1}])"), "its scene has no meshes");
    expect_refused(square_gltf(R"([{"children":[7]}])"), "its nodes do not form a tree");
    expect_refused(square_gltf(R"([{"children":[0]}])"), "its nodes do not form a tree");
    expect_refused(square_gltf(R"([{"mesh":0},{"mesh":0})"), "not valid JSON");
}

TEST(SurfaceHeader, RefusesNodesThatAreSharedOrTheirOwnAncestors) {
    std::string nodes = "[";
    for (int i = 1; i < 64; ++i) nodes += R"({"children":[)" + std::to_string(i) + ',' + std::to_string(i) + "]},";
    expect_refused(square_gltf(nodes + R"({"mesh":0}])"), "its nodes do not form a tree");
    std::string chain = "[";
    for (int i = 1; i < 600; ++i) chain += R"({"children":[)" + std::to_string(i) + "]},";
    EXPECT_TRUE(header_of(square_gltf(chain + R"({"mesh":0}])")));
    expect_refused(square_gltf(chain + R"({"mesh":0,"children":[0]}])"), "its nodes do not form a tree");
}

TEST(SurfaceHeader, RefusesAccessorsThatNeedTooMuchMemory) {
    std::string json = square_gltf();
    json.replace(json.find(R"("count":4,)"), 10, R"("count":4000000000,)");
    expect_refused(json, "max-faces", ErrorCode::LimitExceeded);
}

TEST(SurfaceHeader, CountsThePixelsOfPictures) {
    const std::string png = *write_greys(std::vector<std::uint16_t>(6), 3, 2, 8);
    const std::string file = textured_glb(png);
    const auto header = *read_surface_header(file, SurfaceFormat::Glb, kMaxFaces, 100);
    EXPECT_EQ(header.texels, 6U);
    EXPECT_EQ(header.max_pixels, 100U);
    EXPECT_GT(header.decoder_bytes, header_of(file)->decoder_bytes);
    EXPECT_EQ(header_of(file)->texels, 0U);
    EXPECT_EQ(read_surface_header(file, SurfaceFormat::Glb, kMaxFaces, 5)->texels, 0U);  // cannot be read
    for (std::size_t size = 28; size < file.size(); ++size)
        EXPECT_FALSE(read_surface_header(file.substr(0, size), SurfaceFormat::Glb, kMaxFaces, 100)) << size;
    const std::string broken = textured_gltf(R"("bufferView":1e9)"), far = textured_gltf(R"("bufferView":0)");
    for (const std::string& json : {broken, far})
        EXPECT_EQ(read_surface_header(glb(json, "x"), SurfaceFormat::Glb, kMaxFaces, 100)->texels, 0U);
}

TEST(SurfaceHeader, RefusesDataInOtherFilesAndUnsupportedExtensions) {
    expect_refused(square_gltf(R"([{"mesh":0}])", R"(,"uri":"../square.bin")"),
                   "its data is in another file (../square.bin); send a GLB, or embed the data");
    std::string json = square_gltf();
    json.insert(1, R"("extensionsRequired":["EXT_meshopt_compression"],)");
    expect_refused(json, "the extension EXT_meshopt_compression is not supported");
}

}  // namespace
}  // namespace ccdt::api
