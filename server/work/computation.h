// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stop_token>

#include "api/image/image_codec.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/work/compute_request.h"

namespace ccdt::server {

/// The form of delivery of an answer, in addition to what the request says.
struct Delivery {
    bool compressed = false;        ///< compress the body if that is worthwhile
    api::BodySink* sink = nullptr;  ///< receives a large body in pieces; null: the body is returned whole
    std::stop_token unwanted = {};  ///< stopped once nobody needs the answer, not even a partial one
};

/// Computes the answer to a valid request. May take any time.
///
/// When `control` requests a stop, the computation ends within a pass. The result is then the error Stopped or, if the
/// request allows it, a partial answer.
/// Errors: those of the operation, and Internal if the computation failed. After an error, pieces of the body that were
/// delivered before it are useless. `timings` has the stages up to the end.
using Compute = std::function<Result<api::Answer>(const ComputeRequest& request, const Delivery& delivery,
                                                  const Control& control, api::Timings& timings)>;

/// Computes an answer in this thread.
/// @param decode  functions that decode pictures
Result<api::Answer> compute_here(const ComputeRequest& request, const Delivery& delivery, const api::Limits& limits,
                                 const api::Decode& decode, const Control& control, api::Timings& timings);

}  // namespace ccdt::server
