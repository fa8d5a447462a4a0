// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// Outcome of a run that reaches its deadline: an error, or a partial result.
enum class OnStop { Error, Partial };

/// Checks that no stop was requested. Errors: Stopped.
Result<void> check_stop(const std::stop_token& stop);

/// Checks that a result is complete, or that partial results are accepted. Errors: Stopped.
/// @param stopped  whether a stop ended the computation of the result early
Result<void> check_whole(bool stopped, OnStop on_stop);

/// Returns the token that stops the writing of an answer. If partial results are accepted, no stop is ever requested
/// for it, because the partial result must still be written.
std::stop_token stop_of_writing(const Control& control, OnStop on_stop);

}  // namespace ccdt::api
