#pragma once

#include <functional>

#include "api/image/image_codec.h"
#include "server/compute/compute_protocol.h"
#include "server/work/computation.h"

namespace ccdt::server {

/// A function that computes an answer: compute_here, or what a test puts in its place.
using Computer = std::function<Result<api::Answer>(const ComputeRequest& request, const Delivery& delivery,
                                                   const api::Limits& limits, const api::Decode& decode,
                                                   const Control& control, api::Timings& timings)>;

/// Answers calls that come over the channel, one after the other, until its other end is closed: then the process ends
/// at once, whatever it is doing. See compute_protocol.h.
///
/// A computation is given as many threads as the server lends it, which begin when they are first wanted and end with
/// it.
[[noreturn]] void run_compute_process(ComputeFiles files, const Computer& compute);

}  // namespace ccdt::server
