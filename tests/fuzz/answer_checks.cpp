// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/answer_checks.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "api/text/text.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

using Json = nlohmann::json;

/// Parses JSON that must not contain null, which stands for NaN and infinity.
Json parse(const std::string& body) {
    const auto json = Json::parse(body, nullptr, false);
    CCDT_CHECK(!json.is_discarded());
    CCDT_CHECK(body.find("null") == std::string::npos);
    return json;
}

void append_points(const Json& list, std::vector<Point>& points) {
    for (const Json& point : list) points.push_back({point.at(0).get<double>(), point.at(1).get<double>()});
}

void check_run(const Json& run) {
    CCDT_CHECK(run.at("variation").get<double>() >= 0);
    CCDT_CHECK(run.at("iterations").get<double>() >= 0);
    if (!run.contains("trace")) return;
    for (const Json& step : run.at("trace")) CCDT_CHECK(step.at("variation").get<double>() >= 0);
}

/// Checks the outlines of ink, if there are any.
void check_rings(const Json& part) {
    if (!part.contains("rings")) return;
    for (const Json& ring : part.at("rings")) {
        CCDT_CHECK(ring.size() >= 3);
        for (const Json& corner : ring) CCDT_CHECK(corner.size() == 2);
    }
}

double number(std::string_view text) {
    const auto value = api::parse_number<double>(text);
    CCDT_CHECK(value && std::isfinite(*value));
    return *value;
}

}  // namespace

void check_cost(const api::Cost& cost) {
    CCDT_CHECK(std::isfinite(cost.seconds) && cost.seconds >= 0);
    CCDT_CHECK(cost.memory > 0 && cost.memory < std::size_t{1} << 40);
}

std::vector<Point> points_of_json(const std::string& body) {
    const Json json = parse(body);
    std::vector<Point> points;
    for (const Json& part : json.value("inks", Json::array())) {
        check_rings(part);
        if (json.contains("points")) continue;
        check_run(part);
        append_points(part.at("points"), points);
    }
    if (json.contains("points")) {
        check_run(json);
        check_rings(json);
        append_points(json.at("points"), points);
    }
    CCDT_CHECK(json.at("sites").get<std::size_t>() == points.size());
    return points;
}

std::vector<Point> points_of_feature(const std::string& body) {
    const Json json = parse(body);
    check_run(json.at("properties"));
    std::vector<Point> points;
    append_points(json.at("geometry").at("coordinates"), points);
    return points;
}

std::vector<Point> points_of_lines(std::string_view body) {
    std::vector<Point> points;
    while (!body.empty()) {
        auto line = api::take_until(body, "\n");
        if (line.starts_with('\x1e')) line.remove_prefix(1);
        append_points(Json::array({parse(std::string(line)).at("geometry").at("coordinates")}), points);
    }
    return points;
}

std::vector<Point> points_of_csv(std::string_view body) {
    const auto title = api::take_until(body, "\r\n");
    CCDT_CHECK(title == "x,y" || title == "x,y,ink" || title == "x,y,rank" || title == "x,y,radius,side" ||
               title == "x,y,radius,flips,ground");
    std::vector<Point> points;
    while (!body.empty()) {
        auto line = api::take_until(body, "\r\n");
        const double x = number(api::take_until(line, ","));
        const double y = number(api::take_until(line, ","));
        points.push_back({x, y});
    }
    return points;
}

std::vector<Point> points_of_npy(std::string_view body, std::size_t columns) {
    check_signature(body, "\x93NUMPY");
    const auto end = body.find('\n');
    CCDT_CHECK(end != std::string_view::npos);
    body.remove_prefix(end + 1);
    CCDT_CHECK(body.size() % (columns * sizeof(double)) == 0);
    std::vector<Point> points(body.size() / (columns * sizeof(double)));
    for (std::size_t i = 0; i < points.size(); ++i)
        std::memcpy(&points[i], body.data() + i * columns * sizeof(double), sizeof(Point));
    return points;
}

void check_svg(std::string_view body) {
    check_signature(body, "<svg ");
    CCDT_CHECK(body.ends_with("</svg>\n"));
    CCDT_CHECK(body.find("nan") == std::string_view::npos && body.find("inf") == std::string_view::npos);
}

void check_signature(std::string_view body, std::string_view signature) {
    CCDT_CHECK(body.starts_with(signature));
}

std::string without_time(std::string body) {
    constexpr std::string_view kName = "\"elapsed_ms\":";
    const auto at = body.find(kName);
    if (at == std::string::npos) return body;
    const auto begin = at + kName.size();
    return body.erase(begin, body.find_first_of(",}", begin) - begin);
}

}  // namespace ccdt::fuzz
