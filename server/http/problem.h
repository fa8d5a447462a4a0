#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/result.h"
#include "server/http/message.h"

namespace ccdt::server {

/// The reason why a request, or a job, has no result: the one kind of error that clients are told. The floors below
/// have Errors, which `problem` makes one of these.
struct Problem {
    int status = 500;
    Error error;                       ///< as the client is told it
    std::vector<Header> headers = {};  ///< that go with the status
    std::string cause = {};            ///< of a failure of ours, for the log
};

/// The value that a function gives, or why the client gets no result.
template <class T>
using HttpResult = tl::expected<T, Problem>;

/// Status that an error of the floors below is answered with.
int http_status(ErrorCode code);

/// Makes a problem of an error or of words. Of a failure of ours (500) clients are told no more than that it is one;
/// the words become its cause.
tl::unexpected<Problem> problem(Error error);
tl::unexpected<Problem> problem(int status, std::string message);

/// Refuses what may end well a little later.
tl::unexpected<Problem> busy(int status, std::string message, std::chrono::seconds retry_after);

}  // namespace ccdt::server
