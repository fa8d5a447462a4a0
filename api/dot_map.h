#pragma once

#include "api/sample.h"

namespace ccdt::api {

/// Answers a request to /sample that has counts: makes each feature's area, distributes its points, and writes which
/// feature and class each is of. Features that have points but no area get none, with a warning.
///
/// Parameters and errors are those of run_sample(); of a feature that is not valid, or without density, with a pointer
/// to it.
Result<Answer> run_dot_map(const SampleRequest& request, const Limits& limits, const Decode& decode,
                           const Control& control, Timings& timings, BodyTaker* taker = nullptr);

}  // namespace ccdt::api
