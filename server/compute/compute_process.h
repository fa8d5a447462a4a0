// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "api/image/image_codec.h"
#include "server/compute/compute_protocol.h"
#include "server/work/computation.h"

namespace ccdt::server {

/// A function that computes an answer: compute_here, or a replacement in tests.
using Computer = std::function<Result<api::Answer>(const ComputeRequest& request, const Delivery& delivery,
                                                   const api::Limits& limits, const api::Decode& decode,
                                                   const Control& control, api::Timings& timings)>;

/// Answers the server's calls on `files.channel`, one at a time. Once the server closes its end of the channel, the
/// process ends at once, even during a computation. See compute_protocol.h.
///
/// A computation gets as many threads as the server lends it. The threads start when they are first needed and end with
/// the computation.
[[noreturn]] void run_compute_process(ComputeFiles files, const Computer& compute);

}  // namespace ccdt::server
