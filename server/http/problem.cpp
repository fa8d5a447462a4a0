#include "server/http/problem.h"

#include <utility>

namespace ccdt::server {

int http_status(ErrorCode code) {
    switch (code) {
        case ErrorCode::Malformed:
            return 400;
        case ErrorCode::Unusable:
            return 422;
        case ErrorCode::LimitExceeded:
            return 413;
        case ErrorCode::NotAcceptable:
            return 406;
        case ErrorCode::Unsupported:
            return 415;
        case ErrorCode::Stopped:
            return 503;
        case ErrorCode::Internal:
            break;
    }
    return 500;
}

tl::unexpected<Problem> problem(int status, std::string message, std::string field) {
    return tl::unexpected<Problem>(
        Problem{status, Error{ErrorCode::Internal, std::move(message), std::move(field)}, {}, {}, true});
}

tl::unexpected<Problem> problem(Error error) {
    const int status = http_status(error.code);
    return tl::unexpected<Problem>(Problem{status, std::move(error), {}, {}, true});
}

tl::unexpected<Problem> problem(Fault fault) {
    auto refused = problem(fault.status, std::move(fault.detail));
    refused.value().headers = std::move(fault.headers);
    return refused;
}

tl::unexpected<Problem> busy(int status, std::string message, std::chrono::seconds retry_after) {
    auto refused = problem(status, std::move(message));
    refused.value().headers.push_back({"Retry-After", std::to_string(retry_after.count())});
    return refused;
}

}  // namespace ccdt::server
