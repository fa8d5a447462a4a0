// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/surface_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/image/srgb.h"
#include "api/output/json_pieces.h"
#include "api/output/records.h"
#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

/// Appends `,"name":[x,y,z]`, with numbers rounded to 32-bit floats.
void append_triple_member(std::string& out, std::string_view name, const Point3& p) {
    out.append(",\"").append(name).append("\":");
    append_array(out, std::array{p.x, p.y, p.z},
                 [](std::string& to, double ordinate) { append_shortest(to, static_cast<float>(ordinate)); });
}

/// Bounding box of positions.
struct Bounds {
    Point3 min{kFar, kFar, kFar};
    Point3 max{-kFar, -kFar, -kFar};

    void include(const Point3& p) {
        min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
        max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
    }

    /// Checks that 32-bit floats can hold positions relative to a reference. Errors: Unusable.
    Result<void> check_floats(const Point3& reference = {}) const {
        constexpr double kLargest = std::numeric_limits<float>::max();
        for (const Point3& p : {min - reference, max - reference}) {
            if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kLargest)
                return failure(
                    ErrorCode::Unusable,
                    "the coordinates exceed the range of the 32-bit floats of this format; choose another one",
                    "format");
        }
        return {};
    }

    /// Returns the centre if 32-bit floats relative to the origin would lose much more precision than relative to the
    /// centre; otherwise the origin.
    Point3 reference() const {
        constexpr double kFarFromOrigin = 64;  ///< in multiples of the longest side
        const Point3 size = max - min, centre = 0.5 * (min + max);
        const bool is_far = std::max({std::abs(centre.x), std::abs(centre.y), std::abs(centre.z)}) >
                            kFarFromOrigin * std::max({size.x, size.y, size.z});
        return is_far ? centre : Point3();
    }

private:
    static constexpr double kFar = std::numeric_limits<double>::infinity();
};

/// Array of a glTF file, in a buffer view of its own.
struct GlbArray {
    std::string_view attribute;                 ///< name of the vertex attribute; empty for the indices of triangles
    std::string_view type;                      ///< type of the elements
    std::size_t elements;                       ///< number of vertices or triangles
    std::size_t bytes;                          ///< size of an element, a multiple of 4
    std::function<void(std::size_t i)> append;  ///< appends an element to the body
};

/// Returns the JSON of a glTF file with one primitive.
/// @param mode       topology of the primitive: 0 for points, 4 for triangles
/// @param reference  position to which the stored positions are relative
std::string describe_glb(int mode, std::span<const GlbArray> arrays, const Bounds& bounds, const Point3& reference) {
    std::string attributes, indices, accessors, views;
    std::size_t offset = 0;
    for (std::uint64_t i = 0; i < arrays.size(); ++i) {
        const GlbArray& each = arrays[i];
        const bool is_indices = each.attribute.empty();
        const std::string number = std::to_string(i), comma = i > 0 ? "," : "";
        if (is_indices)
            indices = ",\"indices\":" + number;
        else
            attributes.append(comma).append("\"").append(each.attribute).append("\":").append(number);
        accessors.append(comma).append("{\"bufferView\":").append(number);
        append_member(accessors, "componentType", std::uint64_t{is_indices ? 5125U : 5126U});  // uint or float
        append_member(accessors, "count", std::uint64_t{is_indices ? 3 * each.elements : each.elements});
        accessors.append(",\"type\":\"").append(each.type).append("\"");
        if (i == 0) {
            append_triple_member(accessors, "min", bounds.min - reference);
            append_triple_member(accessors, "max", bounds.max - reference);
        }
        accessors += '}';
        views.append(comma).append("{\"buffer\":0");
        append_member(views, "byteOffset", std::uint64_t{offset});
        append_member(views, "byteLength", std::uint64_t{each.elements * each.bytes});
        append_member(views, "target", std::uint64_t{is_indices ? 34963U : 34962U});  // indices or attributes
        views += '}';
        offset += each.elements * each.bytes;
    }
    std::string node = "{\"mesh\":0";
    if (reference != Point3()) {
        node += ",\"translation\":";
        append_numbers(node, std::array{reference.x, reference.y, reference.z});
    }
    return R"({"asset":{"version":"2.0","generator":"ccdt"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)" + node +
           R"(}],"meshes":[{"primitives":[{"attributes":{)" + attributes + '}' + indices +
           ",\"mode\":" + std::to_string(mode) + R"(}]}],"accessors":[)" + accessors + R"(],"bufferViews":[)" + views +
           R"(],"buffers":[{"byteLength":)" + std::to_string(offset) + "}]}";
}

/// Writes a glTF file with one primitive.
/// @param position  returns the position of a vertex
/// @param arrays    further arrays, after the positions
template <class Position>
Result<void> write_glb(int mode, std::size_t vertices, Position position, std::vector<GlbArray> arrays, Body& body,
                       const std::stop_token& stop) {
    constexpr std::size_t kFileHeader = 12, kChunkHeader = 8, kAlignment = 4;
    Bounds bounds;
    for (std::size_t i = 0; i < vertices; ++i) bounds.include(position(i));
    const Point3 reference = bounds.reference();
    if (auto fits = bounds.check_floats(reference); !fits) return fits;
    std::string& out = body.text();
    arrays.insert(arrays.begin(), {"POSITION", "VEC3", vertices, 12,
                                   [&](std::size_t i) { append_floats(out, position(i) - reference); }});
    std::string json = describe_glb(mode, arrays, bounds, reference);
    json.append((kAlignment - json.size() % kAlignment) % kAlignment, ' ');
    std::size_t content = 0;
    for (const GlbArray& each : arrays) content += each.elements * each.bytes;
    const std::size_t size = kFileHeader + 2 * kChunkHeader + json.size() + content;
    if (size > std::numeric_limits<std::uint32_t>::max())
        return failure(ErrorCode::LimitExceeded, "a GLB file has at most 4 GiB; choose another format", "format");
    body.expect(size);
    out += "glTF";
    append_binary(out, std::uint32_t{2});
    append_binary(out, static_cast<std::uint32_t>(size));
    append_binary(out, static_cast<std::uint32_t>(json.size()));
    out.append("JSON").append(json);
    append_binary(out, static_cast<std::uint32_t>(content));
    out.append("BIN\0", 4);
    for (const GlbArray& each : arrays) write_records(each.elements, body, stop, each.append);
    return {};
}

}  // namespace

std::vector<Column> PlacedSurface::columns() const {
    std::vector<Column> columns = {{"x", "x", "double"},
                                   {"y", "y", "double"},
                                   {"z", "z", "double"},
                                   {"face", "face", "uint"},
                                   {"u", "barycentric_u", "float"},
                                   {"v", "barycentric_v", "float"},
                                   {"w", "barycentric_w", "float"},
                                   {"nx", "nx", "float"},
                                   {"ny", "ny", "float"},
                                   {"nz", "nz", "float"}};
    if (has_colours())
        columns.insert(columns.end(), {{"r", "red", "uchar"}, {"g", "green", "uchar"}, {"b", "blue", "uchar"}});
    if (has_texture()) columns.insert(columns.end(), {{"s", "s", "float"}, {"t", "t", "float"}});
    if (!dots.ranks.empty()) columns.push_back({"rank", "rank", "uint"});
    return columns;
}

void PlacedSurface::read_row(std::size_t i, std::vector<double>& row) const {
    const Point3 at = position(i), across = normal(i);
    const auto [u, v, w] = weights(i);
    row.assign({at.x, at.y, at.z, static_cast<double>(face(i)), u, v, w, across.x, across.y, across.z});
    if (has_colours()) {
        for (const float light : colour(i)) row.push_back(to_srgb(static_cast<double>(light)));
    }
    if (has_texture()) {
        for (const float ordinate : texture(i)) row.push_back(static_cast<double>(ordinate));
    }
    if (!dots.ranks.empty()) row.push_back(dots.ranks[i]);
}

Result<void> write_ply_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    const SurfaceMesh& mesh = *placed.dots.mesh;
    std::string& out = body.text();
    out += ply_header(mesh.vertices.size());
    out.append("property double x\nproperty double y\nproperty double z\nelement face ")
        .append(std::to_string(mesh.triangles.size()))
        .append("\n");
    out += "property list uchar int vertex_indices\nend_header\n";
    write_records(mesh.vertices.size(), body, stop, [&](std::size_t i) { append_doubles(out, mesh.vertices[i]); });
    write_records(mesh.triangles.size(), body, stop, [&](std::size_t i) {
        append_binary(out, std::uint8_t{3});
        append_binary(out, mesh.triangles[i]);
    });
    return {};
}

Result<void> write_glb_points(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    std::string& out = body.text();
    const std::size_t size = placed.size();
    std::vector<GlbArray> arrays = {
        {"NORMAL", "VEC3", size, 12, [&](std::size_t i) { append_floats(out, placed.normal(i)); }}};
    if (placed.has_colours())
        arrays.push_back({"COLOR_0", "VEC3", size, 12, [&](std::size_t i) { append_binary(out, placed.colour(i)); }});
    if (placed.has_texture())
        arrays.push_back(
            {"TEXCOORD_0", "VEC2", size, 8, [&](std::size_t i) { append_binary(out, placed.texture(i)); }});
    arrays.push_back(
        {"_FACE", "SCALAR", size, 4, [&](std::size_t i) { append_binary(out, static_cast<float>(placed.face(i))); }});
    arrays.push_back({"_BARYCENTRIC", "VEC3", size, 12, [&](std::size_t i) {
                          const auto [u, v, w] = placed.weights(i);
                          append_floats(out, {u, v, w});
                      }});
    return write_glb(
        0, size, [&](std::size_t i) { return placed.position(i); }, std::move(arrays), body, stop);
}

Result<void> write_glb_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    const SurfaceMesh& mesh = *placed.dots.mesh;
    return write_glb(
        4, mesh.vertices.size(), [&](std::size_t i) { return mesh.vertices[i]; },
        {{"", "SCALAR", mesh.triangles.size(), 12,
          [&](std::size_t i) { append_binary(body.text(), mesh.triangles[i]); }}},
        body, stop);
}

Result<void> write_obj_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    const SurfaceMesh& mesh = *placed.dots.mesh;
    std::string& out = body.text();
    write_records(mesh.vertices.size(), body, stop, [&](std::size_t i) {
        out += 'v';
        const auto& [x, y, z] = mesh.vertices[i];
        for (const double ordinate : {x, y, z}) {
            out += ' ';
            append_number(out, ordinate);
        }
        out += '\n';
    });
    write_records(mesh.triangles.size(), body, stop, [&](std::size_t i) {
        out += 'f';
        for (const std::uint32_t vertex : mesh.triangles[i]) {
            out += ' ';
            append_index(out, vertex + 1);
        }
        out += '\n';
    });
    return {};
}

Result<void> write_stl_mesh(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    constexpr std::size_t kHeader = 80;
    const SurfaceMesh& mesh = *placed.dots.mesh;
    Bounds bounds;
    for (const Point3& p : mesh.vertices) bounds.include(p);
    if (auto fits = bounds.check_floats(); !fits) return fits;
    std::string& out = body.text();
    std::string header = "triangulation by ccdt";  // must not begin with `solid`, by which readers recognise text
    header.resize(kHeader);
    out += header;
    append_binary(out, static_cast<std::uint32_t>(mesh.triangles.size()));
    write_records(mesh.triangles.size(), body, stop, [&](std::size_t i) {
        const auto& [a, b, c] = mesh.triangles[i];
        const Point3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
        const Point3 across = cross(q - p, r - p);
        const double area = length(across);
        append_floats(out, area > 0 ? (1 / area) * across : across);
        for (const Point3& corner : {p, q, r}) append_floats(out, corner);
        append_binary(out, std::uint16_t{0});
    });
    return {};
}

}  // namespace ccdt::api
