// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/result.h"
#include "server/http/message.h"

namespace ccdt::server {

/// The reason why a request or a job has no result: the only kind of error that clients see. api and core return
/// Errors, which `problem` converts.
struct Problem {
    int status = 500;
    Error error;                       ///< the error as the client sees it
    std::vector<Header> headers = {};  ///< additional headers of the answer
    std::string cause = {};            ///< cause of an internal failure, for the log
};

/// The value of a function, or why the client gets no result.
template <class T>
using HttpResult = tl::expected<T, Problem>;

/// Returns the status for an error of api or core.
int http_status(ErrorCode code);

/// Makes a problem of an error or a message. If the status is 500, the client learns only that the server failed; the
/// message becomes the cause, for the log.
tl::unexpected<Problem> problem(Error error);
tl::unexpected<Problem> problem(int status, std::string message);

/// Makes a refusal of a request that may succeed later.
tl::unexpected<Problem> busy(int status, std::string message, std::chrono::seconds retry_after);

}  // namespace ccdt::server
