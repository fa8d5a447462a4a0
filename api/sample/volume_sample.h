// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "api/decode/decode.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "api/sample/volume_formats.h"
#include "api/sample/volume_parser.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

/// Creates the domain and the density, and distributes points. Errors: those of run_volume() except errors of writing.
Result<PlacedVolume> place_volume(const VolumeRequest& request, const Decode& decode, const Control& control,
                                  Timings& timings);

/// Writes placed points in the requested format, or in another one.
///
/// @param placed  result of place_volume() for `request`
/// @param sink    as for run_volume()
/// Errors: those of writing in run_volume(); Malformed if the format needs the tetrahedra, and the request does not ask
/// for them.
Result<Answer> write_answer(const VolumeRequest& request, const PlacedVolume& placed, const VolumePointFormat& format,
                            const Control& control, Timings& timings, BodySink* sink = nullptr);

/// Distributes points in space, and writes them in the requested format.
///
/// @param control  a requested stop ends the run within one pass over the points
/// @param sink     receives the body in pieces if the body is larger than Body::kMaxInMemory; null: the answer contains
///                 the whole body
/// @returns        the answer; without its body if the sink received the body
/// Errors: those of `decode`, VoxelDensity::create() and distribute_in_volume(); for a solid, those of
/// Surface::create(), Solid::create() and distribute_in_solid(); those of the format; Stopped, unless the request
/// accepts a partial result. The same request gives the same bytes, except for `elapsed_ms` in JSON.
Result<Answer> run_volume(const VolumeRequest& request, const Decode& decode, const Control& control, Timings& timings,
                          BodySink* sink = nullptr);

/// Estimates the cost of computing an answer, before voxels or a mesh are read.
Cost cost_of(const VolumeRequest& request);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const VolumeRequest& request);

}  // namespace ccdt::api
