#include "server/http/http_server.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

#include "tests/server/running_server.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kRequest = "GET / HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n";

/// Answers with `hello`, faults with their status.
Response greet(const Request&, const std::optional<Fault>& fault, Connection&) {
    Response response;
    response.status = fault ? fault->status : 200;
    response.media_type = "text/plain";
    response.body = "hello";
    return response;
}

bool is_answered(const RunningServer& server, const std::string& status) {
    const std::string answer = Client(server.port()).ask(kRequest);
    return answer.starts_with("HTTP/1.1 " + status) && answer.ends_with("\r\n\r\nhello");
}

TEST(HttpServer, AnswersThoughItsLoggerThrows) {
    std::atomic<int> logged = 0;
    RunningServer server({}, greet, [&](const Exchange&) {
        ++logged;
        throw std::runtime_error("the disk is full");
    });
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(is_answered(server, "200"));
    server.stop();
    EXPECT_EQ(logged, 3);
    EXPECT_EQ(server.connections().open, 0u);
}

TEST(HttpServer, RefusesThoughItsLoggerThrows) {
    std::atomic<int> logged = 0;
    RunningServer server({.connections = 0}, greet, [&](const Exchange&) {
        ++logged;
        throw std::runtime_error("the disk is full");
    });
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(is_answered(server, "503"));
    server.stop();
    EXPECT_EQ(logged, 3);
    EXPECT_EQ(server.connections().refused, 3u);
}

}  // namespace
}  // namespace ccdt::server
