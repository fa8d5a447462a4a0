// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "api/decode/decode.h"
#include "server/compute/compute_protocol.h"
#include "server/requests/compute.h"

namespace ccdt::server {

/// A function that computes an answer: compute_here() or, in tests, a replacement.
using ComputeFunction = std::function<Result<api::Answer>(const ComputeRequest& request, const Delivery& delivery,
                                                          const api::Limits& limits, const api::Decode& decode,
                                                          const Control& control, api::Timings& timings)>;

/// Answers the calls of the server on `files.channel` (see compute_protocol.h), one at a time. Ends the process as soon
/// as the server closes the channel, even during a computation.
///
/// A computation uses at most `files.threads` threads, which start when needed and end with the computation.
[[noreturn]] void run_compute_process(ComputeFiles files, const ComputeFunction& compute);

}  // namespace ccdt::server
