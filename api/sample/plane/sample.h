// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/decode/decode.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "api/sample/plane/placement.h"
#include "api/sample/plane/sample_area.h"
#include "api/sample/plane/sample_request.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// Points of a request that are placed. They can be written in several formats.
struct PlacedSample {
    SampleArea area;
    PlacedPoints placed;
    double elapsed = 0;  ///< computing time so far, milliseconds
};

/// Builds the domain and the density, and distributes points. Errors: those of run_sample(), except for errors of
/// writing.
/// @param request  without a threshold mask
Result<PlacedSample> place_sample(const SampleRequest& request, const Limits& limits, const Decode& decode,
                                  const Control& control, Timings& timings);

/// Writes placed points in the requested format, or in another one.
///
/// @param placed  result of place_sample() for `request`
/// @param sink    as for run_sample()
/// Errors: those of writing in run_sample(); Malformed if the format needs an option that the request does not give.
Result<Answer> write_answer(const SampleRequest& request, const PlacedSample& placed, const PointFormat& format,
                            const Limits& limits, const Control& control, Timings& timings, BodySink* sink = nullptr);

/// Builds the domain and the density, distributes points, and writes them in the requested format. In a dot map, the
/// points of each class are distributed in each feature. A feature without area gets no points; if its count is not 0,
/// the answer has a warning.
///
/// @param request  without a threshold mask, which run_mask() computes
/// @param control  a requested stop ends the run within one pass over the points
/// @param sink     receives the body in pieces if the body is larger than Body::kMaxInMemory; null: the answer contains
///                 the whole body
/// @returns        the answer; without its body if the sink received the body
/// Errors: Unusable if the domain has no area, or none after exclusions and buffer; Unusable for an invalid polygon if
/// the request rejects invalid polygons; Unusable if the density is zero everywhere in the domain or, in a dot map, in
/// a feature that has points; those of `decode`; LimitExceeded if a drawing would have more than limits.max_pixels;
/// Stopped, unless the request accepts a partial result. Error::field is a JSON Pointer or an option's name. The same
/// request gives the same bytes, except for `elapsed_ms` in JSON.
Result<Answer> run_sample(const SampleRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodySink* sink = nullptr);

}  // namespace ccdt::api
