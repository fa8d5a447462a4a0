// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/problem.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

namespace ccdt::api {

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
        case ErrorCode::Unavailable:
        case ErrorCode::Stopped:
            return 503;
        case ErrorCode::Internal:
            break;
    }
    return 500;
}

std::string problem_json(int status, std::string_view title, const Error& error, std::string_view instance) {
    std::string detail = error.message;
    for (const Error& other : error.others) detail += "; " + other.message;
    nlohmann::ordered_json problem = {
        {"type", "about:blank"}, {"title", title}, {"status", status}, {"detail", std::move(detail)}};
    if (!instance.empty()) problem["instance"] = instance;
    const auto add = [&](const Error& one) {
        if (!one.field.empty()) problem["errors"].push_back({{"pointer", one.field}, {"detail", one.message}});
    };
    add(error);
    std::ranges::for_each(error.others, add);
    return problem.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace ccdt::api
