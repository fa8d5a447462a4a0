// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/problem.h"

#include <utility>

#include "api/problem.h"

namespace ccdt::server {
namespace {

/// Value of Retry-After if a resource is temporarily unavailable.
constexpr std::chrono::seconds kSoon{2};

}  // namespace

tl::unexpected<Problem> problem(Error error) {
    const int status = api::http_status(error.code);
    if (error.code == ErrorCode::Unavailable) {
        auto refused = busy(status, error.message, kSoon);
        refused.value().cause = std::move(error.message);
        return refused;
    }
    if (status != 500) return tl::unexpected<Problem>(Problem{status, std::move(error)});
    Error told{error.code, "the server failed; its log contains the cause", {}};
    return tl::unexpected<Problem>(Problem{status, std::move(told), {}, std::move(error.message)});
}

tl::unexpected<Problem> problem(int status, std::string message) {
    Error error{ErrorCode::Internal, std::move(message), {}};
    if (status == 500) return problem(std::move(error));
    return tl::unexpected<Problem>(Problem{status, std::move(error)});
}

tl::unexpected<Problem> busy(int status, std::string message, std::chrono::seconds retry_after) {
    auto refused = problem(status, std::move(message));
    refused.value().headers.push_back({"Retry-After", std::to_string(retry_after.count())});
    return refused;
}

}  // namespace ccdt::server
