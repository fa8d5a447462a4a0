#include "api/problem.h"

#include <nlohmann/json.hpp>

namespace ccdt::api {

std::string problem_json(int status, std::string_view title, const Error& error, std::string_view instance) {
    nlohmann::ordered_json problem = {
        {"type", "about:blank"}, {"title", title}, {"status", status}, {"detail", error.message}};
    if (!instance.empty()) problem["instance"] = instance;
    if (!error.field.empty()) {
        nlohmann::ordered_json cause = {{"pointer", error.field}, {"detail", error.message}};
        problem["errors"] = nlohmann::ordered_json::array({std::move(cause)});
    }
    return problem.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace ccdt::api
