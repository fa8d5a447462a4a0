// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/sample.h"

namespace ccdt::api {

/// Answers a request to /sample that has counts: computes the area of each feature, distributes its points, and writes
/// the feature and class of each point. A feature without area gets no points, and a warning if its count is not 0.
///
/// Parameters and errors are those of run_sample(). If a feature is invalid or has no density, the error's field is a
/// JSON Pointer to the feature.
Result<Answer> run_dot_map(const SampleRequest& request, const Limits& limits, const Decode& decode,
                           const Control& control, Timings& timings, BodySink* sink = nullptr);

}  // namespace ccdt::api
