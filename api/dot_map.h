// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/sample.h"

namespace ccdt::api {

/// Answers a request to /sample that has counts: computes the area of each feature, distributes its points, and writes
/// the feature and class of each point. A feature that has points but no area gets none, with a warning.
///
/// Parameters and errors are those of run_sample(). Errors about a feature that is invalid or has no density have a
/// JSON Pointer to it.
Result<Answer> run_dot_map(const SampleRequest& request, const Limits& limits, const Decode& decode,
                           const Control& control, Timings& timings, BodyTaker* taker = nullptr);

}  // namespace ccdt::api
