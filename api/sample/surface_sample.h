// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "api/decode/decode.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "api/sample/placed_surface.h"
#include "api/sample/surface_request.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

/// Reads the mesh, makes a surface of its triangles, and distributes points on it. Errors: those of run_surface()
/// except errors of writing.
Result<PlacedSurface> place_surface(const SurfaceRequest& request, const Decode& decode, const Control& control,
                                    Timings& timings);

/// Writes placed points in the requested format, or in another one.
///
/// @param placed  result of place_surface() for `request`
/// @param sink    as for run_surface()
/// Errors: those of writing in run_surface(); Malformed if the format needs the triangulation, and the request does not
/// ask for it.
Result<Answer> write_answer(const SurfaceRequest& request, const PlacedSurface& placed,
                            const SurfacePointFormat& format, const Control& control, Timings& timings,
                            BodySink* sink = nullptr);

/// Distributes points on the surface of a mesh, and writes them in the requested format.
///
/// @param control  a requested stop ends the run within one pass over the points
/// @param sink     receives the body in pieces if the body is larger than Body::kMaxInMemory; null: the answer contains
///                 the whole body
/// @returns        the answer; without its body if the sink received the body
/// Errors: those of `decode` and Surface::create(); Unusable if the density is zero everywhere, if the density follows
/// the colours of a mesh without colours, and if the format cannot hold the coordinates; Malformed if the number of
/// densities is not that of the vertices; LimitExceeded if the answer is too large for the format; Stopped, unless the
/// request accepts a partial result. The same request gives the same bytes, except for `elapsed_ms` in JSON.
Result<Answer> run_surface(const SurfaceRequest& request, const Decode& decode, const Control& control,
                           Timings& timings, BodySink* sink = nullptr);

/// Estimates the cost of computing an answer, before the mesh is read.
Cost cost_of(const SurfaceRequest& request);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const SurfaceRequest& request);

}  // namespace ccdt::api
