// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/volume_formats.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/run_options.h"
#include "api/output/json_pieces.h"
#include "api/output/records.h"
#include "core/ccdt/volume/unwrapped_mesh.h"

namespace ccdt::api {
namespace {

void write_doubles(std::span<const Point3> points, Body& body, const std::stop_token& stop) {
    write_records(points.size(), body, stop, [&](std::size_t i) { append_doubles(body.text(), points[i]); });
}

Result<void> write_json(const PlacedVolume& placed, Body& body, const std::stop_token& stop) {
    std::string& out = body.text();
    out += "{\"points\":";
    write_list(body, std::span(placed.dots.points), append_position, stop);
    append_member(out, "sites", std::uint64_t{placed.size()});
    append_member(out, "seed", placed.seed);
    const auto quality = std::ranges::find(qualities(), placed.quality, &Choice<Quality>::value);
    out.append(",\"quality\":\"").append(quality->word).append("\"");
    append_outcome(out, placed);
    write_ranks(body, placed.dots.ranks, stop);
    if (const auto& mesh = placed.dots.mesh)
        write_mesh(std::span(mesh->vertices), "tetrahedra", std::span(mesh->tetrahedra), body, stop);
    out += "}\n";
    return {};
}

/// Calls write(mesh) with the tetrahedra as they lie in space.
template <class Write>
Result<void> with_tetrahedra(const PlacedVolume& placed, Write write) {
    if (!placed.dots.mesh) return write(TetrahedronMesh{placed.dots.points, {}});  // after a stop
    if (!placed.domain.periodic) return write(*placed.dots.mesh);
    const auto mesh = unwrapped(*placed.dots.mesh, placed.domain.sides);
    if (mesh) return write(*mesh);
    return failure(ErrorCode::Unusable,
                   "this format cannot hold a torus with so few points that a tetrahedron is wider than half a side; "
                   "use json",
                   "format");
}

/// Writes an unstructured grid.
/// @param cells  [n] the vertices of each cell, as numbers of 32 bits
/// @param type   type of the cells in VTK
template <class Cell>
void write_grid(std::span<const Point3> vertices, std::span<const Cell> cells, std::uint8_t type, Body& body,
                const std::stop_token& stop) {
    constexpr std::size_t kCorners = sizeof(Cell) / sizeof(std::uint32_t);  // NOLINT(bugprone-sizeof-expression)
    const std::size_t count = cells.size();
    std::string& out = body.text();
    std::size_t offset = 0;
    const auto declare = [&](std::string_view element, std::string_view kind, std::size_t bytes) {
        out.append("<DataArray type=\"").append(kind).append("\" Name=\"").append(element);
        if (kind == "Float64") out += "\" NumberOfComponents=\"3";
        out.append("\" format=\"appended\" offset=\"").append(std::to_string(offset)).append("\"/>\n");
        offset += sizeof(std::uint64_t) + bytes;
    };
    out +=
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
        std::to_string(vertices.size()) + "\" NumberOfCells=\"" + std::to_string(count) + "\">\n<Points>\n";
    declare("Points", "Float64", vertices.size_bytes());
    out += "</Points>\n<Cells>\n";
    declare("connectivity", "UInt32", cells.size_bytes());
    declare("offsets", "Int64", count * sizeof(std::int64_t));
    declare("types", "UInt8", count);
    out += "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
    append_binary(out, std::uint64_t{vertices.size_bytes()});
    write_doubles(vertices, body, stop);
    append_binary(out, std::uint64_t{cells.size_bytes()});
    write_records(count, body, stop, [&](std::size_t i) { append_binary(out, cells[i]); });
    append_binary(out, std::uint64_t{count * sizeof(std::int64_t)});
    write_records(count, body, stop, [&](std::size_t i) { append_binary(out, std::int64_t(kCorners * (i + 1))); });
    append_binary(out, std::uint64_t{count});
    write_records(count, body, stop, [&](std::size_t) { append_binary(out, type); });
    out += "\n</AppendedData>\n</VTKFile>\n";
}

Result<void> write_vtu_points(const PlacedVolume& placed, Body& body, const std::stop_token& stop) {
    constexpr std::uint8_t kVertex = 1;
    std::vector<std::uint32_t> cells(placed.size());
    std::iota(cells.begin(), cells.end(), std::uint32_t{0});
    write_grid(std::span(placed.dots.points), std::span<const std::uint32_t>(cells), kVertex, body, stop);
    return {};
}

Result<void> write_vtu_mesh(const PlacedVolume& placed, Body& body, const std::stop_token& stop) {
    constexpr std::uint8_t kTetrahedron = 10;
    return with_tetrahedra(placed, [&](const TetrahedronMesh& mesh) -> Result<void> {
        write_grid(std::span(mesh.vertices), std::span(mesh.tetrahedra), kTetrahedron, body, stop);
        return {};
    });
}

Result<void> write_msh(const PlacedVolume& placed, Body& body, const std::stop_token& stop) {
    constexpr std::int32_t kVolume = 3, kTetrahedron = 4, kOne = 1, kZero = 0;  // dimension, type and tags in Gmsh
    return with_tetrahedra(placed, [&](const TetrahedronMesh& mesh) -> Result<void> {
        std::string& out = body.text();
        /// Appends a section's totals, and the header of its only block. Numbers of nodes and elements begin at 1.
        const auto begin = [&](std::string_view section, std::uint64_t count, std::int32_t kind) {
            out.append("$").append(section).append("\n");
            append_binary(out, std::array<std::uint64_t, 4>{1, count, 1, count});
            append_binary(out, std::array{kVolume, kOne, kind});
            append_binary(out, count);
        };
        out += "$MeshFormat\n4.1 1 8\n";
        append_binary(out, kOne);  // shows the order of bytes
        out += "\n$EndMeshFormat\n";
        begin("Nodes", mesh.vertices.size(), kZero);
        write_records(mesh.vertices.size(), body, stop, [&](std::uint64_t i) { append_binary(out, i + 1); });
        write_doubles(mesh.vertices, body, stop);
        out += "\n$EndNodes\n";
        begin("Elements", mesh.tetrahedra.size(), kTetrahedron);
        write_records(mesh.tetrahedra.size(), body, stop, [&](std::uint64_t i) {
            append_binary(out, i + 1);
            for (const std::uint32_t corner : mesh.tetrahedra[i]) append_binary(out, std::uint64_t{corner} + 1);
        });
        out += "\n$EndElements\n";
        return {};
    });
}

// Costs of writing a point, or a vertex and its share of the tetrahedra.
constexpr Estimate kTextCost{400, 2 * kMicrosecond}, kBinaryCost{200, 0.3 * kMicrosecond};

constexpr VolumePointFormat kJsonPoints{kJson, 7, kTextCost, false, write_json};
constexpr VolumePointFormat kCsvPoints{kCsv, 7, kTextCost, true, write_csv<PlacedVolume>};
constexpr VolumePointFormat kNpyPoints{kNpy, sizeof(Point3), kBinaryCost, true, write_npy<PlacedVolume>};
constexpr VolumePointFormat kPlyPoints{kPly, sizeof(Point3), kBinaryCost, true, write_ply<PlacedVolume>};
// These two formats have no registered media types.
constexpr FileFormat kVtu{"vtu", "VTK unstructured grid", "vtu", "application/x-vtu", ""};
constexpr FileFormat kMsh{"msh", "Gmsh mesh", "msh", "application/x-gmsh", ""};
constexpr VolumePointFormat kVtuFile{kVtu, sizeof(Point3), kBinaryCost, true, write_vtu_points, write_vtu_mesh};
constexpr VolumePointFormat kMshFile{kMsh, sizeof(Point3), kBinaryCost, true, nullptr, write_msh};

constexpr const VolumePointFormat* kFormats[] = {&kJsonPoints, &kCsvPoints, &kNpyPoints,
                                                 &kPlyPoints,  &kVtuFile,   &kMshFile};

}  // namespace

std::span<const VolumePointFormat* const> volume_formats() {
    return kFormats;
}

}  // namespace ccdt::api
