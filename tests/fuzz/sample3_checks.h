// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "api/sample/spatial/sample_request3.h"
#include "tests/fuzz/answer_checks.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {

// Checks of requests for points on surfaces and in space.

/// Whether a bit that stands for an optional property of a request is set.
template <class Given>
bool is_given(std::uint16_t bits, Given property) {
    return (bits & static_cast<std::uint16_t>(property)) != 0;
}

/// Checks the number of points and the mesh of an answer in JSON. Returns the answer.
/// @param cells  name of the list of triangles or tetrahedra
template <class Request>
nlohmann::json check_json(const Request& request, const std::string& body, const char* cells) {
    auto json = nlohmann::json::parse(body, nullptr, false);
    CCDT_CHECK(!json.is_discarded() && body.find("null") == std::string::npos);
    CCDT_CHECK(json.at("points").size() == request.run.sites);
    CCDT_CHECK(json.contains("mesh") == request.run.keep_mesh);
    if (!request.run.keep_mesh) return json;
    const std::size_t vertices = json.at("mesh").at("vertices").size();
    CCDT_CHECK(vertices >= request.run.sites);
    for (const auto& cell : json.at("mesh").at(cells)) {
        for (const auto& vertex : cell) CCDT_CHECK(vertex.template get<std::size_t>() < vertices);
    }
    return json;
}

/// Estimates and answers a request. Calls check_points(request, body) for an answer in JSON.
template <class Request, class CheckPoints>
void check_request(const Result<Request>& request, const api::Decode& decode, CheckPoints check_points) {
    if (!request) return check_error(request.error());
    check_cost(api::cost_of(*request));
    const auto run = [&] {
        api::Timings timings;
        return api::run_sample3(*request, decode, {}, timings);
    };
    const auto answer = run();
    if (!answer) return check_error(answer.error());
    CCDT_CHECK(answer->sites == request->run.sites && !answer->partial);
    CCDT_CHECK(answer->body.size() >= request->run.sites * request->format->least);
    if (request->format->file.name == "json") check_points(*request, answer->body);
    CCDT_CHECK(without_time(answer->body) == without_time(run()->body));
}

}  // namespace ccdt::fuzz
