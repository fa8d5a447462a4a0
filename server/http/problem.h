#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/result.h"
#include "server/http/http.h"

namespace ccdt::server {

/// Why a request is not answered as it wished.
struct Problem {
    int status = 500;
    Error error;
    std::vector<Header> headers;
    Stages stages;
    bool deliver = true;
    std::string_view cancelled = {};
    bool told = false;  ///< a failure of ours, too, is told in these words
};
using Outcome = tl::expected<Response, Problem>;

/// What clients are told of failures of ours.
inline constexpr std::string_view kFailedHere = "the server failed; its log holds the cause";

/// Status that an error of the libraries below is answered with.
int http_status(ErrorCode code);

tl::unexpected<Problem> problem(int status, std::string message, std::string field = {});
tl::unexpected<Problem> problem(Error error);
tl::unexpected<Problem> problem(Fault fault);

/// A refusal that may end well a little later.
tl::unexpected<Problem> busy(int status, std::string message, std::chrono::seconds retry_after);

}  // namespace ccdt::server
