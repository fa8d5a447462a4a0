// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/problem.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

namespace ccdt::api {

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
