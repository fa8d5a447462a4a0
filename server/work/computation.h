#pragma once

#include <functional>

#include "api/image/image_codec.h"
#include "api/options.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/work/question.h"

namespace ccdt::server {

/// How an answer is wanted, besides what its question says.
struct Manner {
    bool compressed = false;  ///< if that is worth it
};

/// Computes the answer to a question, which is right; may take any time.
///
/// Told to stop by the control it ends within a pass, with the error Stopped or what the question allows to give then.
/// Errors: those of the path, Internal if the computation failed. Timings are filled as far as it came.
using Compute = std::function<Result<api::Answer>(const Question& question, const Manner& manner,
                                                  const Control& control, api::Timings& timings)>;

/// The same in this thread.
/// @param decode  reads pictures
Result<api::Answer> compute_here(const Question& question, const Manner& manner, const api::Limits& limits,
                                 const api::Decode& decode, const Control& control, api::Timings& timings);

}  // namespace ccdt::server
