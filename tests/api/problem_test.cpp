#include "api/problem.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace ccdt::api {
namespace {

TEST(Problem, SaysWhatIsWrongAndWhere) {
    const Error error{ErrorCode::Malformed, "sites must be more", "sites"};
    const auto json = nlohmann::json::parse(problem_json(400, "Bad Request", error, "urn:request:7"));
    EXPECT_EQ(json, nlohmann::json::parse(R"({"type": "about:blank", "title": "Bad Request", "status": 400,
        "detail": "sites must be more", "instance": "urn:request:7",
        "errors": [{"pointer": "sites", "detail": "sites must be more"}]})"));
}

TEST(Problem, LeavesOutWhatThereIsNot) {
    const auto json = nlohmann::json::parse(problem_json(500, "Internal Server Error", {}, ""));
    EXPECT_FALSE(json.contains("errors"));
    EXPECT_FALSE(json.contains("instance"));
}

TEST(Problem, ReplacesWhatIsNotUtf8) {
    const Error error{ErrorCode::Malformed, "unknown option '\xff\xc3'", "\xff"};
    EXPECT_TRUE(nlohmann::json::accept(problem_json(400, "Bad Request", error, "\xfe")));
}

}  // namespace
}  // namespace ccdt::api
