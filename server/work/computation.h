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

/// Form in which an answer is wanted, besides what its request says.
struct Delivery {
    bool compressed = false;          ///< if that is worth it
    api::BodyTaker* taker = nullptr;  ///< of a large body, in pieces; null: it is wanted whole
    std::stop_token unwanted = {};    ///< stopped once nobody wants it any more, not even as far as it came
};

/// Computes the answer to a request, which is right; may take any time.
///
/// Told to stop by the control it ends within a pass, with the error Stopped or what the request allows to give then.
/// Errors: those of the path, Internal if the computation failed; also once pieces of the body have been taken, which
/// are of no use then. Timings are filled as far as it came.
using Compute = std::function<Result<api::Answer>(const ComputeRequest& request, const Delivery& delivery,
                                                  const Control& control, api::Timings& timings)>;

/// Computes an answer in this thread.
/// @param decode  reads pictures
Result<api::Answer> compute_here(const ComputeRequest& request, const Delivery& delivery, const api::Limits& limits,
                                 const api::Decode& decode, const Control& control, api::Timings& timings);

}  // namespace ccdt::server
