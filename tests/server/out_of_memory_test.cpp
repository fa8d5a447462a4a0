// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/connection_threads.h"
#include "server/processes/process.h"
#include "tests/server/running_server.h"
#include "tests/server/shortage.h"

namespace ccdt::server {
namespace {

/// Answers with the body of the request.
Response echo(const Request& request, const HttpResult<void>& received, Connection& connection) {
    Response response;
    response.status = received ? 200 : received.error().status;
    if (received) response.body = connection.read_body(request, 100).value_or("");
    return response;
}

std::string ask(const RunningServer& server) {
    return Client(server.port())
        .ask(
            "POST / HTTP/1.1\r\nHost: h\r\nConnection: close\r\nTransfer-Encoding: chunked\r\n\r\n"
            "5\r\nhello\r\n0\r\n\r\n");
}

/// Sends a request while one allocation of the server, with a given number, fails. Then checks that the next request is
/// answered with `status`.
/// @returns  false if the server made fewer allocations
bool survives(int number, const Capacity::Limits& limits, std::string_view status) {
    const std::size_t descriptors = open_descriptors();
    bool failed = false;
    {
        RunningServer server(limits, echo, [](const Exchange&) {});
        EXPECT_TRUE(ask(server).starts_with(status));
        {
            const Shortage shortage(number);
            ask(server);
            failed = shortage.is_over();
        }
        EXPECT_TRUE(ask(server).starts_with(status)) << number;
        server.stop();
        EXPECT_EQ(server.connections().open, 0u) << number;
    }
    EXPECT_EQ(open_descriptors(), descriptors) << number;
    return failed;
}

TEST(OutOfMemory, LosesOnlyOneConnection) {
    int number = 0;
    while (survives(number, {}, "HTTP/1.1 200")) ++number;
    EXPECT_GT(number, 10);
}

TEST(OutOfMemory, LosesOnlyOneRefusal) {
    int number = 0;
    while (survives(number, {.connections = 0, .reserve = 0}, "HTTP/1.1 503")) ++number;
    EXPECT_GT(number, 10);
}

TEST(ConnectionThreads, DropATaskIfMemoryRunsOut) {
    bool accepted = false;
    for (int number = 0; !accepted; ++number) {
        std::atomic<int> done = 0;
        {
            ConnectionThreads threads(std::chrono::hours(1));
            std::function<void()> task = [&] { ++done; };
            {
                const Shortage shortage(number, true);
                accepted = threads.run(std::move(task));
            }
            EXPECT_TRUE(threads.run([&] { ++done; }));
        }
        EXPECT_EQ(done, accepted ? 2 : 1) << number;
    }
}

}  // namespace
}  // namespace ccdt::server
