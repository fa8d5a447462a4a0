// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/image/image_codec.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "api/sample/sample_request.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

/// Builds the domain and the density, distributes points, and writes them in the requested format. In a dot map, the
/// points of each class are distributed in each feature; a feature without area gets no points, and a warning if its
/// count is not 0.
///
/// @param decode   reads a density image or an excluded picture
/// @param control  a stop ends the run within a pass; there is no result unless the request accepts a partial one
/// @param timings  receives the times of the completed stages
/// Errors: Unusable if the domain has no area, or none after exclusions and buffer; for an invalid polygon if the
/// request rejects invalid polygons; and for a density that is zero everywhere, in a dot map in a feature. Those of
/// `decode`; LimitExceeded if a drawing would have more than limits.max_pixels; Stopped. Error::field is a JSON
/// Pointer. Same request, same bytes, except for `elapsed_ms` in JSON.
Result<Answer> run_sample(const SampleRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodySink* sink = nullptr);

}  // namespace ccdt::api
