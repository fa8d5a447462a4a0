// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string_view>

#include "api/run/options.h"
#include "api/sample/plane/sample_request.h"

namespace ccdt::api {

/// Estimates the cost of computing an answer, before the computation begins. Returns an estimate for any parsed
/// request, even if its domain will be rejected.
Cost cost_of(const SampleRequest& request, const Limits& limits);

/// Returns an upper estimate of the size of the answer in bytes.
std::size_t largest_answer(const SampleRequest& request, const Limits& limits);

/// Estimates the cost of parsing a JSON body with parse_sample().
Cost cost_of_parsing(std::string_view body);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const SampleRequest& request);

}  // namespace ccdt::api
