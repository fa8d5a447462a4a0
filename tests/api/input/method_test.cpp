// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "api/sample/plane/sample.h"
#include "api/sample/plane/sample_parser.h"

namespace ccdt::api {
namespace {

const std::string kTorus = R"({"domain":{"type":"torus","width":1,"height":1})";

Result<SampleRequest> parse(const std::string& members) {
    return parse_sample(kTorus + members + '}', {}, "", {});
}

TEST(Method, IsReadByName) {
    for (const Method& method : methods()) {
        const auto read = read_method({"method", "/method", method.name});
        ASSERT_TRUE(read) << method.name;
        EXPECT_EQ(*read, &method);
    }
    for (const std::string_view other : {"", "CVT", "lloyd", "ccdt "}) {
        const auto read = read_method({"method", "/method", other});
        ASSERT_FALSE(read) << other;
        EXPECT_EQ(read.error().code, ErrorCode::Malformed);
        EXPECT_EQ(read.error().field, "/method");
        EXPECT_NE(read.error().message.find("'ccvt'"), std::string::npos) << read.error().message;
    }
}

TEST(Method, HasItsOwnDefaultNumberOfIterations) {
    EXPECT_EQ(parse(R"(,"sites":10)")->run.iterations, Options{}.iterations);
    EXPECT_EQ(parse(R"(,"sites":10,"method":"ccdt")")->run.iterations, Options{}.iterations);
    for (const auto* name : {"cvt", "odt", "ccvt"}) {
        const std::string method = R"(,"sites":10,"method":")" + std::string(name) + '"';
        EXPECT_GE(parse(method)->run.iterations, 50) << name;
        EXPECT_EQ(parse(R"(,"iterations":7)" + method)->run.iterations, 7) << name;
        EXPECT_EQ(parse(method + R"(,"iterations":0)")->run.iterations, 0) << name;
    }
}

TEST(Method, RefusesUnsupportedOptions) {
    const std::vector<std::pair<std::string, std::string>> options = {
        {"iterations", "5"}, {"passes", "5"}, {"quality", R"("draft")"}, {"tolerance", "0.1"}};
    const auto has = [](const Method& method, const std::string& option) {
        return std::ranges::count(option_names(method), option) == 1;
    };
    for (const Method& method : methods()) {
        for (const auto& [option, value] : options) {
            const std::string name(method.name);
            const auto request = parse(R"(,"sites":10,"method":")" + name + R"(",")" + option + R"(":)" + value);
            EXPECT_EQ(request.has_value(), has(method, option)) << name << ", " << option;
            if (request) continue;
            EXPECT_EQ(request.error().code, ErrorCode::Malformed);
            EXPECT_EQ(request.error().field, '/' + option);
            EXPECT_NE(request.error().message.find(name), std::string::npos) << request.error().message;
        }
    }
}

TEST(Method, LimitsTheNumberOfSites) {
    for (const auto& [name, most] : {std::pair{"cvt", 50'000}, {"odt", 500'000}, {"ccvt", 20'000}}) {
        const std::string method = R"(,"method":")" + std::string(name) + R"(","sites":)";
        EXPECT_TRUE(parse(method + std::to_string(most))) << name;
        const auto request = parse(method + std::to_string(most + 1));
        ASSERT_FALSE(request) << name;
        EXPECT_EQ(request.error().code, ErrorCode::LimitExceeded);
        EXPECT_EQ(request.error().field, "/sites");
        for (const std::string& word : {std::string(name), std::to_string(most)}) {
            EXPECT_NE(request.error().message.find(word), std::string::npos) << request.error().message;
        }
    }
    for (const auto* name : {"ccdt", "random"}) {
        EXPECT_TRUE(parse(R"(,"sites":2000000,"method":")" + std::string(name) + '"')) << name;
    }
}

TEST(Method, IsNamedInTheAnswerAndPlacesDifferentPoints) {
    std::vector<nlohmann::json> points;
    for (const Method& method : methods()) {
        const auto request = parse(R"(,"sites":50,"mesh":true,"method":")" + std::string(method.name) + '"');
        ASSERT_TRUE(request);
        Timings timings;
        const auto json = nlohmann::json::parse(run_sample(*request, {}, decode_inline(), {}, timings)->body);
        EXPECT_EQ(json.at("method"), method.name);
        EXPECT_EQ(json.at("points").size(), 50U);
        EXPECT_EQ(json.at("triangles").size(), 100U);
        EXPECT_EQ(json.at("trace").size(), json.at("iterations").get<std::size_t>() + 1);
        EXPECT_EQ(std::ranges::count(points, json.at("points")), 0);
        points.push_back(json.at("points"));
    }
}

TEST(Method, ListsItsOptions) {
    const std::vector<std::string_view> all = {"iterations", "passes", "quality", "tolerance", "fixed"};
    EXPECT_EQ(option_names(methods().front()), all);
    const std::vector<std::string_view> few = {"iterations", "tolerance"};
    for (const auto* name : {"cvt", "odt", "ccvt"})
        EXPECT_EQ(option_names(**read_method({"method", "/method", std::string_view(name)})), few) << name;
    EXPECT_TRUE(option_names(**read_method({"method", "/method", std::string_view("random")})).empty());
}

TEST(Method, StopsOnRequest) {
    for (const std::string name : {"cvt", "odt", "ccvt"}) {
        std::stop_source stop;
        const auto request = parse(R"(,"sites":100,"method":")" + name + '"');
        Timings timings;
        const Control control{stop.get_token(), [&](const Progress&) { stop.request_stop(); }};
        const auto result = run_sample(*request, {}, decode_inline(), control, timings);
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, ErrorCode::Stopped);
    }
}

}  // namespace
}  // namespace ccdt::api
