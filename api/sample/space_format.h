// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/input/file_formats.h"
#include "api/output/body.h"
#include "api/output/json_pieces.h"
#include "api/run/deadline.h"
#include "api/run/estimate.h"
#include "api/run/options.h"
#include "api/run/stopwatch.h"
#include "core/geometry/point3.h"
#include "core/result.h"
#include "core/surface/surface_note.h"

namespace ccdt::api {

/// Format of an answer with points in space: a row of the table in surface_formats.cpp or volume_formats.cpp. The same
/// points give the same bytes, unless the output contains the computing time.
/// @tparam Placed  PlacedSurface or PlacedVolume
template <class Placed>
struct SpaceFormat {
    /// Writes points, or their triangulation. After a stop, the output is incomplete. Errors: LimitExceeded or Unusable
    /// if the format cannot hold the points.
    using Write = Result<void>(const Placed& placed, Body& body, const std::stop_token& stop);

    FileFormat file;
    std::size_t least;              ///< minimum number of bytes that a point takes in the output
    Estimate per_site;              ///< cost of writing a point, or its share of a triangulation
    bool repeats = true;            ///< whether the same points always give the same bytes
    Write* write_points = nullptr;  ///< null: the format is only for triangulations
    Write* write_mesh = nullptr;    ///< null: write_points also writes the triangulation, or omits it

    /// Function that writes the answer to a request; null if the format needs the triangulation, and `mesh` is false.
    /// @param mesh  whether the triangulation was requested
    Write* writer(bool mesh) const { return mesh && write_mesh != nullptr ? write_mesh : write_points; }
};

/// Checks that the triangulation is available if a format needs it.
/// @param mesh  whether the triangulation was requested
/// Errors: Malformed ("mesh").
template <class Placed>
Result<void> check_mesh(const SpaceFormat<Placed>& format, bool mesh) {
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

/// Writes placed points. The parameters are those of write_answer() for requests of each kind.
template <class Request, class Placed>
Result<Answer> write_in_space(const Request& request, const Placed& placed, const SpaceFormat<Placed>& format,
                              const Control& control, Timings& timings, BodySink* sink) {
    Stopwatch watch;
    if (auto can = check_mesh(format, request.run.keep_mesh); !can) return tl::unexpected(can.error());
    Answer answer;
    answer.media_type = format.file.content_type();
    answer.repeats = format.repeats;
    answer.sites = placed.size();
    answer.partial = placed.dots.stopped;
    if (format.file.name != "json") {
        answer.repaired = header_of(placed.repairs);
        answer.warnings = header_of(placed.warnings);
    }
    const std::stop_token stop = stop_of_writing(control, request.on_deadline);
    Body body(answer, sink, control.stop);
    auto written = format.writer(request.run.keep_mesh)(placed, body, stop);
    if (written) written = check_stop(stop);
    timings.encode = watch.lap();
    if (!written) return tl::unexpected(written.error());
    return body.finish(std::move(answer));
}

}  // namespace ccdt::api
