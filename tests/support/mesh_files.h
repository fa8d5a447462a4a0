// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ccdt {

/// Appends a number as little-endian bytes.
template <class Number>
void append_bytes(std::string& out, Number value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// Returns a binary STL with the given coordinates [facets][9].
inline std::string binary_stl(const std::vector<float>& coordinates) {
    std::string file(80, ' ');
    append_bytes(file, static_cast<std::uint32_t>(coordinates.size() / 9));
    for (std::size_t facet = 0; facet < coordinates.size() / 9; ++facet) {
        file.append(12, '\0');  // the normal
        for (std::size_t i = 0; i < 9; ++i) append_bytes(file, coordinates[9 * facet + i]);
        file.append(2, '\0');
    }
    return file;
}

/// Returns a GLB with a JSON chunk and a binary chunk.
inline std::string glb(std::string json, std::string binary) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    std::string file = "glTF";
    append_bytes(file, std::uint32_t{2});
    append_bytes(file, static_cast<std::uint32_t>(28 + json.size() + binary.size()));
    append_bytes(file, static_cast<std::uint32_t>(json.size()));
    file += "JSON" + json;
    append_bytes(file, static_cast<std::uint32_t>(binary.size()));
    file += std::string("BIN\0", 4) + binary;
    return file;
}

/// Returns the positions of the corners of a unit square in the plane z = 0, followed by the indices of its two
/// triangles.
inline std::string square_buffer() {
    std::string buffer;
    for (const float value : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 1.F, 1.F, 0.F, 0.F, 1.F, 0.F}) append_bytes(buffer, value);
    for (const int index : {0, 1, 2, 0, 2, 3}) append_bytes(buffer, static_cast<std::uint16_t>(index));
    return buffer;
}

/// Returns the JSON of a glTF whose buffer is square_buffer().
/// @param nodes   the array of nodes; mesh 0 is the square, and node 0 is in the scene
/// @param buffer  further members of the buffer
inline std::string square_gltf(std::string_view nodes = R"([{"mesh":0}])", std::string_view buffer = "") {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":)" + std::string(nodes) +
           R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[)"
           R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
           R"({"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],"bufferViews":[)"
           R"({"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],)"
           R"("buffers":[{"byteLength":60)" +
           std::string(buffer) + "}]}";
}

/// Returns the JSON of a glTF with the square of square_gltf(), whose material has a picture as its colour. The texture
/// coordinates are the positions, so the first row of the picture is at y = 0.
/// @param image    members of the image
/// @param sampler  members of the sampler
/// @param colour   further members of the texture reference
/// @param rest     further members of the material
inline std::string textured_gltf(std::string_view image, std::string_view sampler = "", std::string_view colour = "",
                                 std::string_view rest = "") {
    std::string json = square_gltf();
    const auto insert = [&json](std::string_view before, const std::string& text) {
        json.insert(json.find(before), text);
    };
    insert("},\"indices\"", R"(,"TEXCOORD_0":2)");
    insert("}]}],\"accessors\"", R"(,"material":0)");
    insert("],\"bufferViews\"", R"(,{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"})");
    insert("],\"buffers\"", R"(,{"buffer":0,"byteOffset":60,"byteLength":32})");
    json.replace(json.find("\"byteLength\":60}"), 15, "\"byteLength\":92");
    json.pop_back();
    return json +
           R"(,"extensionsUsed":["KHR_texture_transform"],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0)" +
           std::string(colour) + "}}" + std::string(rest) +
           R"(}],"textures":[{"source":0,"sampler":0}],"samplers":[{)" + std::string(sampler) + R"(}],"images":[{)" +
           std::string(image) + "}]}";
}

/// Returns a GLB of textured_gltf() that contains the picture. The parameters are those of textured_gltf().
/// @param picture  file of the picture
inline std::string textured_glb(const std::string& picture, std::string_view sampler = "", std::string_view colour = "",
                                std::string_view rest = "") {
    std::string json = textured_gltf(R"("bufferView":3,"mimeType":"image/png")", sampler, colour, rest);
    std::string buffer = square_buffer();
    for (const float value : {0.F, 0.F, 1.F, 0.F, 1.F, 1.F, 0.F, 1.F}) append_bytes(buffer, value);
    const std::string size = std::to_string(picture.size());
    json.insert(json.find("],\"buffers\""), R"(,{"buffer":0,"byteOffset":92,"byteLength":)" + size + '}');
    json.replace(json.find("\"byteLength\":92}"), 15, "\"byteLength\":" + std::to_string(92 + picture.size()));
    return glb(json, buffer + picture);
}

}  // namespace ccdt
