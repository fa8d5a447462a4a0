#pragma once

#include <stop_token>

#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

/// Outcome of a run that a deadline stops: an error, or what there is by then.
enum class OnStop { Error, Partial };

/// Checks that nothing was asked to stop. Errors: Stopped.
Result<void> check_stop(const std::stop_token& stop);

/// Checks that a distribution is whole, or that its part will do. Errors: Stopped.
Result<void> check_whole(const Distribution& distribution, OnStop on_stop);

/// Makes the token that ends the writing of an answer: one that never does where a part is to be told in full.
std::stop_token stop_of_writing(const Control& control, OnStop on_stop);

}  // namespace ccdt::api
