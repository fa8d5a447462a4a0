// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/problem.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace ccdt::api {
namespace {

TEST(HttpStatus, CoversEveryKindOfError) {
    EXPECT_EQ(http_status(ErrorCode::Malformed), 400);
    EXPECT_EQ(http_status(ErrorCode::Unusable), 422);
    EXPECT_EQ(http_status(ErrorCode::LimitExceeded), 413);
    EXPECT_EQ(http_status(ErrorCode::NotAcceptable), 406);
    EXPECT_EQ(http_status(ErrorCode::Unsupported), 415);
    EXPECT_EQ(http_status(ErrorCode::Stopped), 503);
    EXPECT_EQ(http_status(ErrorCode::Internal), 500);
}

TEST(Problem, WritesMessageAndPointer) {
    const Error error{ErrorCode::Malformed, "sites must be more", "sites"};
    const auto json = nlohmann::json::parse(problem_json(400, "Bad Request", error, "urn:request:7"));
    EXPECT_EQ(json, nlohmann::json::parse(R"({"type": "about:blank", "title": "Bad Request", "status": 400,
        "detail": "sites must be more", "instance": "urn:request:7",
        "errors": [{"pointer": "sites", "detail": "sites must be more"}]})"));
}

TEST(Problem, ListsAllErrors) {
    Error error{ErrorCode::Malformed, "sites must be more", "sites"};
    error.others = {{ErrorCode::Unsupported, "this is HEIC", ""},
                    {ErrorCode::Malformed, "scale must be less", "scale"}};
    const auto json = nlohmann::json::parse(problem_json(400, "Bad Request", error, ""));
    EXPECT_EQ(json.at("detail"), "sites must be more; this is HEIC; scale must be less");
    EXPECT_EQ(json.at("errors"), nlohmann::json::parse(R"([{"pointer": "sites", "detail": "sites must be more"},
        {"pointer": "scale", "detail": "scale must be less"}])"));
}

TEST(Problem, OmitsMissingMembers) {
    const auto json = nlohmann::json::parse(problem_json(500, "Internal Server Error", {}, ""));
    EXPECT_FALSE(json.contains("errors"));
    EXPECT_FALSE(json.contains("instance"));
}

TEST(Problem, ReplacesInvalidUtf8) {
    const Error error{ErrorCode::Malformed, "unknown option '\xff\xc3'", "\xff"};
    EXPECT_TRUE(nlohmann::json::accept(problem_json(400, "Bad Request", error, "\xfe")));
}

}  // namespace
}  // namespace ccdt::api
