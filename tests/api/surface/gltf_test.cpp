// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/gltf.h"

#include <gtest/gtest.h>

#include "api/text/base64.h"
#include "tests/api/surface/cube.h"
#include "tests/support/mesh_files.h"

namespace ccdt::api {
namespace {

using test::expect_cube;
using test::expect_refused;
using test::kCorners;
using test::kFaces;
using test::read_mesh;

constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
              kFloat = 5126;

/// Makes glTF files of the unit cube.
class Maker {
public:
    /// Makes a file with other types of positions and indices.
    /// @param full  value of a coordinate of 1
    /// @param more  further members of the accessor of positions
    template <class Number = float, class Index = std::uint16_t>
    static Maker of(int type = kFloat, int index_type = kUnsignedShort, Number full = 1, std::string_view more = "") {
        Maker maker;
        std::vector<Number> positions;
        for (const auto& [x, y, z] : kCorners) {
            for (const double ordinate : {x, y, z}) positions.push_back(ordinate > 0 ? full : Number{0});
        }
        std::vector<Index> indices;
        for (const auto& face : kFaces) {
            for (const std::size_t k : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<Index>(face[k]));
        }
        maker.add(positions, type, "VEC3", 3, more);
        maker.add(indices, index_type, "SCALAR", 1);
        return maker;
    }

    /// Adds an accessor with a buffer view.
    /// @param more  further members of the accessor
    /// @returns  its index
    template <class Number>
    int add(const std::vector<Number>& values, int type, std::string_view shape, std::size_t components,
            std::string_view more = "") {
        const std::size_t at = buffer.size();
        for (const Number value : values) append_bytes(buffer, value);
        views += (views.empty() ? "" : ",") + (R"({"buffer":0,"byteOffset":)" + std::to_string(at)) +
                 R"(,"byteLength":)" + std::to_string(buffer.size() - at) + '}';
        accessors += (accessors.empty() ? "" : ",") + (R"({"bufferView":)" + std::to_string(count)) +
                     R"(,"componentType":)" + std::to_string(type) + R"(,"count":)" +
                     std::to_string(values.size() / components) + R"(,"type":")" + std::string(shape) + '"' +
                     std::string(more) + '}';
        buffer.resize((buffer.size() + 3) / 4 * 4, '\0');
        return count++;
    }

    std::string json(std::string_view buffers = "") const {
        return R"({"asset":{"version":"2.0"},)" + scenes + R"("nodes":)" + nodes + R"(,"meshes":[{"primitives":[)" +
               primitives + ']' + mesh + R"(}],"accessors":[)" + accessors + R"(],"bufferViews":[)" + views +
               R"(],"buffers":[)" +
               (buffers.empty() ? R"({"byteLength":)" + std::to_string(buffer.size()) + '}' : std::string(buffers)) +
               ']' + rest + '}';
    }
    std::string file() const { return glb(json(), buffer); }
    std::string data_uri() const { return "data:application/octet-stream;base64," + base64(buffer); }

    std::string scenes = R"("scene":0,"scenes":[{"nodes":[0]}],)", nodes = R"([{"mesh":0}])",
                primitives = R"({"attributes":{"POSITION":0},"indices":1})", mesh, rest, accessors, views, buffer;
    int count = 0;
};

TEST(Gltf, ReadsAllTypesOfNumbers) {
    constexpr std::string_view kNormalised = R"(,"normalized":true)";
    const Maker makers[] = {
        Maker::of(),
        Maker::of<float, std::uint8_t>(kFloat, kUnsignedByte),
        Maker::of<float, std::uint32_t>(kFloat, kUnsignedInt),
        Maker::of<std::int8_t>(kByte),
        Maker::of<std::uint8_t>(kUnsignedByte),
        Maker::of<std::int16_t>(kShort),
        Maker::of<std::uint16_t>(kUnsignedShort),
        Maker::of<std::int8_t>(kByte, kUnsignedShort, 127, kNormalised),
        Maker::of<std::uint8_t>(kUnsignedByte, kUnsignedShort, 255, kNormalised),
        Maker::of<std::int16_t>(kShort, kUnsignedShort, 32767, kNormalised),
        Maker::of<std::uint16_t>(kUnsignedShort, kUnsignedShort, 65535, kNormalised),
    };
    for (Maker maker : makers) {
        maker.rest = R"(,"extensionsRequired":["KHR_mesh_quantization"])";
        expect_cube(maker.file());
    }
}

TEST(Gltf, ReadsContainersThatAreNotPadded) {
    Maker maker = Maker::of();
    std::string json = maker.json();
    while (json.size() % 4 != 1) json.insert(1, " ");
    const auto file = [&](std::size_t length, std::size_t padding) {
        std::string text = "glTF";
        append_bytes(text, std::uint32_t{2});
        append_bytes(text, static_cast<std::uint32_t>(28 + json.size() + padding + maker.buffer.size()));
        append_bytes(text, static_cast<std::uint32_t>(length));
        text += "JSON" + json + std::string(padding, ' ');
        append_bytes(text, static_cast<std::uint32_t>(maker.buffer.size()));
        return text + std::string("BIN\0", 4) + maker.buffer;
    };
    expect_cube(file(json.size(), 0));      // no padding
    expect_cube(file(json.size(), 3));      // padding that is not counted
    expect_cube(file(json.size() + 3, 3));  // as specified
    expect_cube(file(json.size(), 0) + "rest", "bytes after the end of the GLB are ignored");
    expect_refused(file(json.size() + 5000, 0), "its JSON chunk, with ");
    std::string damaged = file(json.size(), 0);
    damaged[20 + json.size() + 3] = 1;
    expect_refused(damaged, "exceeds the file");
    damaged[8] = 19, damaged[9] = damaged[10] = damaged[11] = 0;
    expect_refused(damaged, "its header announces only 19 bytes");
}

TEST(Gltf, ReadsBuffersInDataUris) {
    Maker maker = Maker::of();
    const std::string size = std::to_string(maker.buffer.size());
    expect_cube(maker.json(R"({"byteLength":)" + size + R"(,"uri":")" + maker.data_uri() + R"("})"));
    expect_cube(maker.json(R"({"byteLength":)" + size + R"(,"uri":"DATA)" + maker.data_uri().substr(4) + R"("})"));
    maker.views.replace(maker.views.find(R"("buffer":0)"), 10, R"("buffer":1)");
    const std::string buffer = R"({"uri":")" + maker.data_uri() + R"(","byteLength":)" + size + '}';
    expect_cube(maker.json(buffer + ',' + buffer));
    expect_refused(maker.json(buffer + R"(,{"uri":"data:,abc","byteLength":3})"), "fewer than it announces");
    expect_refused(maker.json(buffer + R"(,{"byteLength":3})"), "buffer 1 has no data");
    expect_refused(maker.json(buffer + R"(,{"uri":"data:;base64,!","byteLength":3})"), "buffer 1 is not base64");
    expect_refused(maker.json(buffer + R"(,{"uri":"cube.bin","byteLength":3})"),
                   "its data is in another file (cube.bin)");
}

TEST(Gltf, ReadsTheRootNodesOfAFileWithoutScenes) {
    Maker maker = Maker::of();
    maker.scenes = "";
    maker.nodes = R"([{"mesh":0,"translation":[0,0,1]},{"children":[0],"translation":[2,0,0]}])";
    expect_cube(maker.file(), "", {2, 0, 1});
    maker.scenes = R"("scenes":[{"nodes":[]},{"nodes":[1]}],"scene":1,)";
    expect_cube(maker.file(), "", {2, 0, 1});
    maker.scenes = R"("scenes":[{"nodes":[]},{"nodes":[1]}],)";
    expect_refused(maker.file(), "its scene has no meshes");
}

TEST(Gltf, AppliesAllKindsOfTransformations) {
    Maker maker = Maker::of();
    // Two quarter turns about z, then about x, of a cube that is scaled by 2.
    maker.nodes = R"([{"mesh":0,"scale":[2,2,2],"translation":[3,0,0],"rotation":[0.5,0.5,0.5,0.5]}])";
    const auto turned = read_mesh(maker.file());
    ASSERT_TRUE(turned) << turned.error().message;
    EXPECT_EQ(turned->soup.vertices[1], (Point3{3, 2, 0}));
    EXPECT_NEAR(test::volume_of(turned->soup), 8, 1e-12);
    // A reflection keeps the normals outside.
    maker.nodes = R"([{"mesh":0,"matrix":[0,1,0,0,1,0,0,0,0,0,1,0,0,0,7,1]}])";
    expect_cube(maker.file(), "", {0, 0, 7});
    maker.nodes = R"([{"mesh":0,"scale":[-1,1,1],"translation":[1,0,0]}])";
    expect_cube(maker.file());
}

TEST(Gltf, ReadsStripsAndFans) {
    for (const bool is_strip : {true, false}) {
        Maker maker = Maker::of();
        maker.add<std::uint8_t>(
            is_strip ? std::vector<std::uint8_t>{0, 1, 3, 2} : std::vector<std::uint8_t>{0, 1, 2, 3}, kUnsignedByte,
            "SCALAR", 1);
        maker.primitives =
            R"({"attributes":{"POSITION":0},"indices":2,"mode":)" + std::string(is_strip ? "5" : "6") + '}';
        const auto contents = read_mesh(maker.file());
        ASSERT_TRUE(contents) << contents.error().message;
        ASSERT_EQ(contents->soup.triangles.size(), 2U);
        double area = 0;
        for (const auto& [a, b, c] : contents->soup.triangles) {
            const auto& v = contents->soup.vertices;
            area += cross(v[b] - v[a], v[c] - v[a]).z / 2;
        }
        EXPECT_EQ(area, 1);
    }
}

TEST(Gltf, IgnoresPointsAndLinesWithAWarning) {
    Maker maker = Maker::of();
    for (const char* mode : {"0", "1", "2", "3"}) {
        maker.primitives = R"({"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"mode":)" +
                           std::string(mode) + '}';
        expect_cube(maker.file(), "points and lines, which have no area, are ignored: 1");
    }
    maker.primitives = R"({"attributes":{"POSITION":0},"indices":1},{"attributes":{"NORMAL":0}})";
    expect_cube(maker.file());
}

TEST(Gltf, AppliesTheWeightsOfMorphTargets) {
    Maker maker = Maker::of();
    std::vector<float> moves;
    for (int i = 0; i < 8; ++i) moves.insert(moves.end(), {0, 0, 4});
    maker.add(moves, kFloat, "VEC3", 3);
    maker.primitives =
        R"({"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":2},{"NORMAL":2},{"POSITION":2}]})";
    expect_cube(maker.file());
    maker.mesh = R"(,"weights":[0.5,1,0])";
    expect_cube(maker.file(), "", {0, 0, 2});
    maker.nodes = R"([{"mesh":0,"weights":[0,0,0.25]}])";
    expect_cube(maker.file(), "", {0, 0, 1});
}

TEST(Gltf, PosesSkinsByTheirJoints) {
    Maker maker = Maker::of();
    std::vector<float> bind{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -5, 0, 1};
    bind.insert(bind.end(), bind.begin(), bind.end());
    maker.add(std::vector<std::uint8_t>(32, 1), kUnsignedByte, "VEC4", 4);
    maker.add(std::vector<float>(32, 0.25F), kFloat, "VEC4", 4);
    maker.add(bind, kFloat, "MAT4", 16);
    maker.primitives = R"({"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"indices":1})";
    maker.rest = R"(,"skins":[{"joints":[0,1],"inverseBindMatrices":4}])";
    // The transformation of the node with the mesh has no effect; those of the ancestors of a joint have.
    maker.nodes = R"([{"mesh":0,"skin":0,"scale":[0.01,-0.01,0.01]},{"translation":[0,5,0]}])";
    expect_cube(maker.file());
    maker.nodes =
        R"([{"mesh":0,"skin":0,"translation":[9,9,9]},{"translation":[0,5,0]},{"children":[1],"translation":[0,0,3]}])";
    expect_cube(maker.file(), "", {0, 0, 3});
    maker.rest = R"(,"skins":[{"joints":[0],"inverseBindMatrices":4}])";
    expect_refused(maker.file(), "accessor 4 has an unsuitable type or number of elements");
    maker.rest = R"(,"skins":[{"joints":[0]}])";
    expect_refused(maker.file(), "vertex 0 of mesh 0 refers to a joint that is missing");
    maker.rest = R"(,"skins":[{"joints":[77,1]}])";
    expect_refused(maker.file(), "skin 0 refers to a node that is missing");
    maker.add(std::vector<float>(32, 0.5F), kFloat, "VEC4", 4);
    maker.primitives = R"({"attributes":{"POSITION":0,"JOINTS_0":5,"WEIGHTS_0":3},"indices":1})";
    maker.rest = R"(,"skins":[{"joints":[0,1]}])";
    expect_refused(maker.file(), "the joints of mesh 0 are not whole numbers");
}

TEST(Gltf, ReadsSparseAccessors) {
    Maker maker = Maker::of();
    const std::string sparse = R"(,"sparse":{"count":2,"indices":{"bufferView":2,"componentType":5121},)"
                               R"("values":{"bufferView":3}})";
    maker.add<std::uint8_t>({6, 0}, kUnsignedByte, "SCALAR", 1);
    maker.add<float>({1, 1, 1, 0, 0, 0}, kFloat, "VEC3", 3);
    maker.accessors.insert(maker.accessors.find('}'), sparse);
    for (std::size_t i = 6 * 12; i < 7 * 12; ++i) maker.buffer[i] = 1;  // replaced
    expect_cube(maker.file());
    maker.buffer[maker.buffer.size() - 28] = 8;
    expect_refused(maker.file(), "a sparse accessor replaces an element that is missing");
    maker.accessors.replace(maker.accessors.find(R"(2,"componentType":5121)"), 22, R"(2,"componentType":5126)");
    expect_refused(maker.file(), "the indices of a sparse accessor are not whole numbers");
    // Without a buffer view, other elements are 0.
    Maker zeros = Maker::of();
    zeros.add<std::uint8_t>({1, 2, 3, 4, 5, 6, 7}, kUnsignedByte, "SCALAR", 1);
    zeros.add<float>({1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1}, kFloat, "VEC3", 3);
    zeros.accessors.replace(1, 15,
                            R"("sparse":{"count":7,"indices":{"bufferView":2,"componentType":5121},)"
                            R"("values":{"bufferView":3}},)");
    expect_cube(zeros.file());
}

TEST(Gltf, ReadsInterleavedAttributes) {
    Maker maker = Maker::of();
    std::vector<float> rows;
    for (const auto& [x, y, z] : kCorners)
        rows.insert(rows.end(), {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 9, 9});
    maker.add(rows, kFloat, "SCALAR", 5);
    maker.views.insert(maker.views.size() - 1, R"(,"byteStride":20)");
    maker.accessors.replace(maker.accessors.rfind("SCALAR"), 6, "VEC3");
    maker.primitives = R"({"attributes":{"POSITION":2},"indices":1})";
    expect_cube(maker.file());
}

TEST(Gltf, WarnsOfUnknownRequiredExtensions) {
    Maker maker = Maker::of();
    maker.rest = R"(,"extensionsRequired":["KHR_materials_unlit","KHR_mesh_quantization"])";
    expect_cube(maker.file());
    maker.rest = R"(,"extensionsRequired":["KHR_texture_transform","CESIUM_RTC"])";
    expect_cube(maker.file(), "required extensions that are unknown are ignored: 1; the first is CESIUM_RTC");
}

TEST(Gltf, NamesWhatIsDamagedOrNotSupported) {
    const auto refused = [](auto change, std::string_view reason) {
        Maker maker = Maker::of();
        change(maker);
        expect_refused(maker.file(), reason);
    };
    refused([](Maker& m) { m.buffer[96] = 8; },
            "triangle 0 of mesh 0 refers to vertex 8, but there are only 8 vertices");
    refused([](Maker& m) { m.primitives = R"({"attributes":{"POSITION":0},"indices":7})"; }, "it has no triangles");
    refused(
        [](Maker& m) {
            m.add<float>({0, 1, 5e30F}, kFloat, "SCALAR", 1);
            m.primitives = R"({"attributes":{"POSITION":0},"indices":2})";
        },
        "the indices of mesh 0 are not whole numbers");
    refused([](Maker& m) { m.accessors.insert(m.accessors.rfind('}'), R"(,"normalized":true)"); },
            "the indices of mesh 0 are not whole numbers");
    refused([](Maker& m) { m.accessors.replace(m.accessors.find("VEC3"), 4, "VEC2"); },
            "accessor 0 has an unsuitable type");
    refused([](Maker& m) { m.accessors.replace(m.accessors.find("5126"), 4, "5130"); },
            "accessor 0 has an unsuitable type");
    refused([](Maker& m) { m.accessors.replace(m.accessors.find(":8,"), 3, ":9,"); },
            "accessor 0 exceeds its buffer view");
    refused([](Maker& m) { m.views.replace(m.views.find(":96"), 3, ":999"); }, "buffer view 0 exceeds its buffer");
    refused([](Maker& m) { m.views.replace(m.views.find(R"("buffer":0)"), 10, R"("buffer":3)"); }, "no valid buffer");
    refused([](Maker& m) { m.rest = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])"; },
            "KHR_draco_mesh_compression is not supported");
    refused(
        [](Maker& m) {
            m.accessors.replace(1, 15, "");
            m.primitives =
                R"({"attributes":{"POSITION":0},"indices":1,"extensions":{"KHR_draco_mesh_compression":{}}})";
        },
        "KHR_draco_mesh_compression is not supported");
    refused([](Maker& m) { m.nodes = R"([{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{}}}])"; },
            "EXT_mesh_gpu_instancing is not supported");
}

}  // namespace
}  // namespace ccdt::api
