// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "api/decode/decode.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "api/surface/surface_header.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

/// Request to /analyze for points on the surface of a mesh.
struct SurfaceAnalyzeRequest {
    SurfaceFile file;
    std::vector<Point3> points;  ///< in the coordinates of the file; projected to the nearest points of the surface
    std::size_t modes = 100;
};

/// Reads a request. The option `points` has the content of a file, as read_point_file3() reads it.
///
/// @param file     the mesh, or the error of its header
/// @param options  options in the order of the request
/// @param accept   the Accept header, empty if there is none
/// Errors: those of `file` and of read_point_file3(); Malformed for an unknown or repeated option, and for a value
/// out of range, or if `points` is missing; Unusable for fewer than 2 points; NotAcceptable if the client does not
/// accept JSON. Error::field is an option's name.
Result<SurfaceAnalyzeRequest> parse_surface_analyze(Result<SurfaceFile> file, const std::vector<TextOption>& options,
                                                    std::string_view accept, const Limits& limits);

/// Reads the mesh, analyses the points on its surface, and writes JSON.
///
/// Errors: those of `decode`, Surface::create() and analyse_surface(). The same request gives the same bytes.
Result<Answer> run_surface_analyze(const SurfaceAnalyzeRequest& request, const Decode& decode, const Control& control,
                                   Timings& timings);

/// Estimates the cost of computing an answer, before the mesh is read.
Cost cost_of(const SurfaceAnalyzeRequest& request);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const SurfaceAnalyzeRequest& request);

}  // namespace ccdt::api
