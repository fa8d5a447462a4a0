#pragma once

#include <functional>

#include "api/image/image_codec.h"
#include "server/processes/unique_fd.h"
#include "server/work/computation.h"

namespace ccdt::server {

/// A function that computes an answer: compute_here, or what a test puts in its place.
using Computer = std::function<Result<api::Answer>(const ComputeRequest& request, const Delivery& delivery,
                                                   const api::Limits& limits, const api::Decode& decode,
                                                   const Control& control, api::Timings& timings)>;

/// Answers calls that come over `channel`, one after the other, until its other end is closed: then the process ends
/// at once, whatever it is doing. See compute_protocol.h.
[[noreturn]] void run_compute_process(UniqueFd channel, UniqueFd events, const Computer& compute);

}  // namespace ccdt::server
