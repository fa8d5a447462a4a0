// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/base/result.h"
#include "server/http/message.h"

namespace ccdt::server {

/// The reason why a request or a job has no result, as the client sees it. `problem` converts an Error of api or core.
struct Problem {
    int status = 500;
    Error error;                       ///< the error as the client sees it
    std::vector<Header> headers = {};  ///< additional headers of the answer
    std::string cause = {};            ///< cause of an internal failure, for the log
};

/// The result of a function, or the problem to report to the client.
template <class T>
using HttpResult = tl::expected<T, Problem>;

/// Converts an error or a message to a problem. If the status is 500, the client learns only that the server failed,
/// and the message becomes the cause for the log.
tl::unexpected<Problem> problem(Error error);
tl::unexpected<Problem> problem(int status, std::string message);

/// Makes a problem with a Retry-After header, for a request that may succeed later.
tl::unexpected<Problem> busy(int status, std::string message, std::chrono::seconds retry_after);

}  // namespace ccdt::server
