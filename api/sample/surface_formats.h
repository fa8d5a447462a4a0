// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <string>

#include "api/input/file_formats.h"
#include "api/output/body.h"
#include "api/run/estimate.h"
#include "api/sample/placed_surface.h"
#include "core/result.h"

namespace ccdt::api {

/// Writes points on a surface, or their triangulation. After a stop, the output is incomplete. Errors: LimitExceeded or
/// Unusable if the format cannot hold the points.
using WriteSurface = Result<void>(const PlacedSurface& placed, Body& body, const std::stop_token& stop);

/// Format of an answer with points on a surface: a row of the table in surface_formats.cpp. The same points give the
/// same bytes, unless the output contains the computing time.
struct SurfacePointFormat {
    FileFormat file;
    std::size_t least;                     ///< minimum number of bytes that a point takes in the output
    Estimate per_site;                     ///< cost of writing a point, or its share of a triangulation
    bool repeats = true;                   ///< whether the same points always give the same bytes
    WriteSurface* write_points = nullptr;  ///< null: the format is only for triangulations
    WriteSurface* write_mesh = nullptr;    ///< null: write_points also writes the triangulation, or omits it

    /// Function that writes the answer to a request; null if the format needs the triangulation, and `mesh` is false.
    /// @param mesh  whether the triangulation was requested
    WriteSurface* writer(bool mesh) const { return mesh && write_mesh != nullptr ? write_mesh : write_points; }
};

/// Returns the formats, in the server's order of preference.
std::span<const SurfacePointFormat* const> surface_formats();

/// Writes repairs or warnings as an array: `[{"pointer":"","detail":"...","face":7}]`, where `face` is the first
/// triangle concerned, if there is one. The output is printable ASCII, because it is also sent in HTTP headers.
std::string write_notes(std::span<const SurfaceNote> notes);

}  // namespace ccdt::api
