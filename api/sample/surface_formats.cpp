// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/surface_formats.h"

#include <string_view>
#include <vector>

#include "api/image/srgb.h"
#include "api/output/json_pieces.h"
#include "api/output/npy_header.h"
#include "api/output/records.h"
#include "api/sample/surface_files.h"
#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

/// Column of a table of points.
struct Column {
    std::string_view name;
    bool is_whole = false;  ///< whether all values are integers
};

std::vector<Column> columns_of(const PlacedSurface& placed) {
    std::vector<Column> columns = {{"x"}, {"y"}, {"z"}, {"face", true}, {"u"}, {"v"}, {"w"}, {"nx"}, {"ny"}, {"nz"}};
    if (placed.has_colours()) columns.insert(columns.end(), {{"r", true}, {"g", true}, {"b", true}});
    if (placed.has_texture()) columns.insert(columns.end(), {{"s"}, {"t"}});
    if (!placed.dots.ranks.empty()) columns.push_back({"rank", true});
    return columns;
}

/// Computes the values of point i in the columns of columns_of().
void fill_row(const PlacedSurface& placed, std::size_t i, std::vector<double>& row) {
    const Point3 place = placed.place(i), normal = placed.normal(i);
    const auto [u, v, w] = placed.weights(i);
    row.assign({place.x, place.y, place.z, static_cast<double>(placed.face(i)), u, v, w, normal.x, normal.y, normal.z});
    if (placed.has_colours()) {
        for (const float light : placed.colour(i)) row.push_back(to_srgb(static_cast<double>(light)));
    }
    if (placed.has_texture()) {
        for (const float ordinate : placed.texture(i)) row.push_back(static_cast<double>(ordinate));
    }
    if (!placed.dots.ranks.empty()) row.push_back(placed.dots.ranks[i]);
}

/// Calls append(row) for each point, until a stop or until the sink of the body fails.
template <class Append>
void write_rows(const PlacedSurface& placed, Body& body, const std::stop_token& stop, Append append) {
    std::vector<double> row;
    write_records(placed.size(), body, stop, [&](std::size_t i) {
        fill_row(placed, i, row);
        append(row);
    });
}

Result<void> write_csv(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    const std::vector<Column> columns = columns_of(placed);
    std::string& out = body.text();
    for (const Column& column : columns) out.append(out.empty() ? "" : ",").append(column.name);
    out += "\r\n";
    write_rows(placed, body, stop, [&](const std::vector<double>& row) {
        for (std::size_t k = 0; k < row.size(); ++k) {
            if (k > 0) out += ',';
            columns[k].is_whole ? append_number(out, static_cast<std::uint64_t>(row[k])) : append_number(out, row[k]);
        }
        out += "\r\n";
    });
    return {};
}

Result<void> write_npy(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    const std::size_t columns = columns_of(placed).size();
    const std::string header = npy_header("<f8", placed.size(), columns);
    body.expect(header.size() + placed.size() * columns * sizeof(double));
    body.text() += header;
    write_rows(placed, body, stop, [&](const std::vector<double>& row) {
        body.text().append(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(double));
    });
    return {};
}

/// Writes the lists of colours and texture coordinates if the file has them.
void write_properties(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    std::string& text = body.text();
    if (placed.has_colours()) {
        const auto append_colour = [&](std::string& out, std::size_t i) {
            append_array(out, placed.colour(i),
                         [](std::string& to, float light) { append_index(to, to_srgb(static_cast<double>(light))); });
        };
        text += ",\"colors\":";
        write_list(body, placed.size(), append_colour, stop);
    }
    if (placed.has_texture()) {
        const auto append_texture = [&](std::string& out, std::size_t i) {
            append_array(out, placed.texture(i), [](std::string& to, float ordinate) { append_number(to, ordinate); });
        };
        text += ",\"texture\":";
        write_list(body, placed.size(), append_texture, stop);
    }
}

void append_run(std::string& out, const PlacedSurface& placed) {
    append_member(out, "sites", std::uint64_t{placed.size()});
    append_member(out, "seed", placed.seed);
    append_member(out, "iterations", static_cast<std::uint64_t>(placed.dots.iterations));
    append_member(out, "variation", placed.dots.variation());
    append_outcome(out, placed);
}

Result<void> write_json(const PlacedSurface& placed, Body& body, const std::stop_token& stop) {
    const std::size_t size = placed.size();
    const auto write = [&](std::string_view name, auto append_element) {
        body.text().append(name);
        write_list(body, size, append_element, stop);
    };
    write("{\"points\":", [&](std::string& out, std::size_t i) { append_position(out, placed.place(i)); });
    write(",\"faces\":", [&](std::string& out, std::size_t i) { append_index(out, placed.face(i)); });
    write(",\"barycentric\":", [&](std::string& out, std::size_t i) { append_numbers(out, placed.weights(i)); });
    write(",\"normals\":", [&](std::string& out, std::size_t i) { append_position(out, placed.normal(i)); });
    write_properties(placed, body, stop);
    append_run(body.text(), placed);
    write_ranks(body, placed.dots.ranks, stop);
    if (const auto& mesh = placed.dots.mesh)
        write_mesh(std::span(mesh->vertices), "triangles", std::span(mesh->triangles), body, stop);
    body.text() += "}\n";
    return {};
}

// Costs of writing a point, or a vertex and two triangles of a triangulation.
constexpr Estimate kTextCost{330, 1.5 * kMicrosecond};
constexpr Estimate kBinaryCost{100, 0.2 * kMicrosecond};

constexpr SurfacePointFormat kJsonPoints{kJson, 24, kTextCost, false, write_json, nullptr};
constexpr SurfacePointFormat kCsvPoints{kCsv, 20, kTextCost, true, write_csv, nullptr};
constexpr SurfacePointFormat kNpyPoints{kNpy, 10 * sizeof(double), kBinaryCost, true, write_npy, nullptr};
constexpr SurfacePointFormat kPlyFile{kPly, 24, kBinaryCost, true, write_ply_points, write_ply_mesh};
constexpr SurfacePointFormat kGlbFile{
    {"glb", "glTF, binary", "glb", "model/gltf-binary", ""}, 12, kBinaryCost, true, write_glb_points, write_glb_mesh};
constexpr SurfacePointFormat kObjFile{
    {"obj", "Wavefront OBJ", "obj", "model/obj", ""}, 8, kTextCost, true, nullptr, write_obj_mesh};
constexpr SurfacePointFormat kStlFile{
    {"stl", "STL", "stl", "model/stl", ""}, 20, kBinaryCost, true, nullptr, write_stl_mesh};

constexpr const SurfacePointFormat* kFormats[] = {&kJsonPoints, &kCsvPoints, &kNpyPoints, &kPlyFile,
                                                  &kGlbFile,    &kObjFile,   &kStlFile};

}  // namespace

std::span<const SurfacePointFormat* const> surface_formats() {
    return kFormats;
}

}  // namespace ccdt::api
