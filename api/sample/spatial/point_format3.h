// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/file_formats.h"
#include "api/output/body.h"
#include "api/output/json_pieces.h"
#include "api/output/npy_header.h"
#include "api/output/records.h"
#include "api/run/estimate.h"
#include "core/base/result.h"
#include "core/ccdt/surface/surface_note.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

/// Format of an answer with points on a surface or in space, which have three coordinates: a row of the table in
/// surface_formats.cpp or volume_formats.cpp. The same points give the same bytes, unless the output contains the
/// computing time.
/// @tparam Placed  PlacedSurface or PlacedVolume, whose read_row() replaces a vector by the values of a point in the
///                 columns()
template <class Placed>
struct PointFormat3 {
    /// Writes points, or their triangulation. After a stop, the output is incomplete. Errors: LimitExceeded or Unusable
    /// if the format cannot hold the points.
    using Write = Result<void>(const Placed& placed, Body& body, const std::stop_token& stop);

    FileFormat file;
    std::size_t least;              ///< minimum number of bytes that a point takes in the output
    Estimate per_site;              ///< cost of writing a point, or its share of a triangulation
    bool repeats = true;            ///< whether the same points always give the same bytes
    Write* write_points = nullptr;  ///< null: the format is only for triangulations
    Write* write_mesh = nullptr;    ///< null: write_points also writes the triangulation, or omits it

    /// Returns the function that writes the answer; null if the format needs the triangulation, and `mesh` is false.
    /// @param mesh  whether the triangulation was requested
    Write* writer(bool mesh) const { return mesh && write_mesh != nullptr ? write_mesh : write_points; }
};

/// Checks that the triangulation is available if a format needs it.
/// @param mesh  whether the triangulation was requested
/// Errors: Malformed ("mesh").
template <class Placed>
Result<void> check_mesh(const PointFormat3<Placed>& format, bool mesh) {
    if (format.writer(mesh) != nullptr) return {};
    return failure(ErrorCode::Malformed,
                   "format=" + std::string(format.file.name) + " is a triangulation, which needs mesh=true", "mesh");
}

/// Writes repairs or warnings as an array: `[{"pointer":"","detail":"...","face":7}]`, where `face` is the first
/// triangle concerned, if there is one. The output is printable ASCII, because it is also sent in HTTP headers.
std::string write_notes(std::span<const SurfaceNote> notes);

/// Returns the notes for an HTTP header; the text is empty if there are none.
std::string header_of(std::span<const SurfaceNote> notes);

/// Appends the members of a JSON answer that describe the outcome of the run.
template <class Placed>
void append_outcome(std::string& out, const Placed& placed) {
    if (placed.dots.stopped) out += ",\"partial\":true";
    if (!placed.repairs.empty()) out.append(",\"repaired\":").append(write_notes(placed.repairs));
    if (!placed.warnings.empty()) out.append(",\"warnings\":").append(write_notes(placed.warnings));
    out += ",\"trace\":";
    append_trace(out, placed.dots.trace);
    append_elapsed(out, placed.elapsed);
}

inline void append_position(std::string& out, const Point3& p) {
    append_numbers(out, std::array{p.x, p.y, p.z});
}

/// Writes the member `mesh` of a JSON answer.
/// @param name  name of the list of triangles or tetrahedra
template <class Cell>
void write_mesh(std::span<const Point3> vertices, std::string_view name, std::span<const Cell> cells, Body& body,
                const std::stop_token& stop) {
    body.text() += ",\"mesh\":{\"vertices\":";
    write_list(body, vertices, append_position, stop);
    body.text().append(",\"").append(name).append("\":");
    write_list(body, cells, append_indices, stop);
    body.text() += '}';
}

/// Column of a table of points.
struct Column {
    std::string_view name;
    std::string_view ply_name;
    std::string_view ply_type;

    bool is_whole() const { return ply_type[0] == 'u'; }
};

/// Calls append(row) for each point, with its values in the columns, until a stop or until the sink of the body fails.
template <class Placed, class Append>
void write_rows(const Placed& placed, Body& body, const std::stop_token& stop, Append append) {
    std::vector<double> row;
    write_records(placed.size(), body, stop, [&](std::size_t i) {
        placed.read_row(i, row);
        append(row);
    });
}

template <class Placed>
Result<void> write_csv(const Placed& placed, Body& body, const std::stop_token& stop) {
    const std::vector<Column> columns = placed.columns();
    std::string& out = body.text();
    for (const Column& column : columns) out.append(out.empty() ? "" : ",").append(column.name);
    out += "\r\n";
    write_rows(placed, body, stop, [&](const std::vector<double>& row) {
        for (std::size_t k = 0; k < row.size(); ++k) {
            if (k > 0) out += ',';
            columns[k].is_whole() ? append_number(out, static_cast<std::uint64_t>(row[k])) : append_number(out, row[k]);
        }
        out += "\r\n";
    });
    return {};
}

template <class Placed>
Result<void> write_npy(const Placed& placed, Body& body, const std::stop_token& stop) {
    const std::size_t columns = placed.columns().size();
    const std::string header = npy_header("<f8", placed.size(), columns);
    body.expect(header.size() + placed.size() * columns * sizeof(double));
    body.text() += header;
    write_rows(placed, body, stop, [&](const std::vector<double>& row) {
        body.text().append(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(double));
    });
    return {};
}

/// Returns the beginning of a binary PLY file, before the properties of vertices.
std::string ply_header(std::size_t vertices);

/// Writes points as the element `vertex` of a binary PLY file. Source: Turk, The PLY Polygon File Format.
template <class Placed>
Result<void> write_ply(const Placed& placed, Body& body, const std::stop_token& stop) {
    const std::vector<Column> columns = placed.columns();
    std::string& out = body.text();
    out += ply_header(placed.size());
    for (const auto& [name, ply_name, type] : columns)
        out.append("property ").append(type).append(" ").append(ply_name).append("\n");
    out += "end_header\n";
    write_rows(placed, body, stop, [&](const std::vector<double>& row) {
        for (std::size_t k = 0; k < row.size(); ++k) {
            if (columns[k].ply_type == "double") append_binary(out, row[k]);
            if (columns[k].ply_type == "float") append_binary(out, static_cast<float>(row[k]));
            if (columns[k].ply_type == "uchar") append_binary(out, static_cast<std::uint8_t>(row[k]));
            if (columns[k].ply_type == "uint") append_binary(out, static_cast<std::uint32_t>(row[k]));
        }
    });
    return {};
}

}  // namespace ccdt::api
