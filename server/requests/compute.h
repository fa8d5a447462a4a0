// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stop_token>

#include "api/decode/decode.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "server/requests/compute_request.h"

namespace ccdt::server {

/// Options for the delivery of an answer that are not part of the request.
struct Delivery {
    bool compressed = false;        ///< compress the body, if is_worth_compressing()
    api::BodySink* sink = nullptr;  ///< receives a large body in pieces; null: the body is returned whole
    std::stop_token unwanted = {};  ///< stopped when not even a partial answer is needed
};

/// Computes the answer to a valid request. The duration is not limited.
///
/// When `control` requests a stop, the computation ends within one pass over the sites. The result is then the error
/// Stopped or, if the request allows it, a partial answer.
/// Errors: those of the operation; Internal if the computation failed. After an error, delivered pieces of the body
/// must be discarded. `timings` receives the durations of all stages that ran.
using Compute = std::function<Result<api::Answer>(const ComputeRequest& request, const Delivery& delivery,
                                                  const Control& control, api::Timings& timings)>;

/// Computes an answer in the calling thread.
/// @param decode  functions that decode pictures
Result<api::Answer> compute_here(const ComputeRequest& request, const Delivery& delivery, const api::Limits& limits,
                                 const api::Decode& decode, const Control& control, api::Timings& timings);

}  // namespace ccdt::server
