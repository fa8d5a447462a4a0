// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/decode/decode.h"
#include "api/output/body.h"
#include "api/run/deadline.h"
#include "api/run/options.h"
#include "api/sample/choice/choice_request.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Chooses candidates and writes them in the requested format. Errors: those of choose_points() and make_density();
/// Stopped, unless the request accepts a partial result. Same request, same bytes.
/// @param decode  decoder of a picture of densities
Result<Answer> run_choice(const ChoiceRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodySink* sink = nullptr);

/// Estimates the cost of run_choice().
Cost cost_of(const ChoiceRequest& request);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const ChoiceRequest& request);

}  // namespace ccdt::api
