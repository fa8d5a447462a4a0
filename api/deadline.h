#pragma once

#include <stop_token>

#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

/// What a run that is stopped, by a deadline, comes to.
enum class OnStop { Error, Partial };

/// Errors: Stopped if it was asked for.
Result<void> check_stop(const std::stop_token& stop);

/// Errors: Stopped for a distribution that was stopped, unless its part will do.
Result<void> check_whole(const Distribution& distribution, OnStop on_stop);

/// Gives what writing an answer listens to: nothing, where a part will do and is to be told in full.
std::stop_token stop_of_writing(const Control& control, OnStop on_stop);

}  // namespace ccdt::api
