// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/http_server.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <future>
#include <stdexcept>
#include <thread>

#include "tests/server/running_server.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kRequest = "GET / HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n";

/// Answers with `hello`, or with the status of the error.
Response greet(const Request&, const HttpResult<void>& received, Connection&) {
    Response response;
    response.status = received ? 200 : received.error().status;
    response.media_type = "text/plain";
    response.body = "hello";
    return response;
}

bool is_answered(const RunningServer& server, const std::string& status) {
    const std::string answer = Client(server.port()).ask(kRequest);
    return answer.starts_with("HTTP/1.1 " + status) && answer.ends_with("\r\n\r\nhello");
}

TEST(HttpServer, AnswersEvenIfItsLoggerThrows) {
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

TEST(HttpServer, ServesConnectedClientsWhileDraining) {
    auto listener = ListeningSocket::open("127.0.0.1", 0).value();
    const int port = listener.port();
    std::atomic<int> logged = 0;
    HttpServer server(std::move(listener), {}, {}, {}, greet, [&](const Exchange&) { ++logged; });
    std::deque<Client> clients;
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(clients.emplace_back(port).say(kRequest));
    server.drain();
    EXPECT_TRUE(server.serve());
    for (const auto& client : clients) EXPECT_TRUE(client.ask("").starts_with("HTTP/1.1 200"));
    EXPECT_EQ(logged, 20);
}

TEST(HttpServer, RefusesEvenIfItsLoggerThrows) {
    std::atomic<int> logged = 0;
    RunningServer server({.connections = 0, .reserve = 0}, greet, [&](const Exchange&) {
        ++logged;
        throw std::runtime_error("the disk is full");
    });
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(is_answered(server, "503"));
    server.stop();
    EXPECT_EQ(logged, 3);
    EXPECT_EQ(server.connections().refused, 3u);
}

TEST(HttpServer, ClosesIdleConnectionsForNewcomers) {
    RunningServer server({.connections = 3, .reserve = 1, .per_address = 0}, greet, [](const Exchange&) {});
    std::deque<Client> idle;
    for (int i = 0; i < 20; ++i) {
        idle.emplace_back(server.port());
        EXPECT_TRUE(is_answered(server, "200")) << i;
    }
    EXPECT_EQ(idle.front().ask(""), "");
    EXPECT_EQ(server.connections().refused, 0u);
}

TEST(HttpServer, ClosesIncompleteHeadsForNewcomers) {
    RunningServer server({.connections = 3, .reserve = 1, .per_address = 0}, greet, [](const Exchange&) {});
    std::deque<Client> slow;
    for (int i = 0; i < 12; ++i) {
        EXPECT_TRUE(slow.emplace_back(server.port()).say("GET / HTTP/1.1\r\nHo")) << i;
        EXPECT_TRUE(is_answered(server, "200")) << i;
    }
    EXPECT_TRUE(slow.front().ask("").starts_with("HTTP/1.1 408"));
    EXPECT_EQ(server.connections().refused, 0u);
}

/// Streams three pieces; the second one is empty.
Response dictate(const Request&, const HttpResult<void>&, Connection&) {
    Response response;
    response.media_type = "text/plain";
    response.stream = [](const Send& send, Record&) {
        for (const std::string_view piece : {"one\n", "", "twenty-four characters.\n"}) EXPECT_TRUE(send(piece));
        return true;
    };
    return response;
}

TEST(HttpServer, EndsIncompleteBodiesWithoutALastChunk) {
    const auto break_off = [](const Request&, const HttpResult<void>&, Connection&) {
        Response response;
        response.stream = [](const Send& send, Record& record) {
            record.cause = "broken";
            return send("a part") && false;
        };
        return response;
    };
    std::atomic<int> status = 0;
    RunningServer server({}, break_off, [&](const Exchange& exchange) { status = exchange.response.status; });
    const std::string answer = Client(server.port()).ask(kRequest);
    EXPECT_TRUE(answer.ends_with("\r\n\r\n6\r\na part\r\n")) << answer;
    server.stop();
    EXPECT_EQ(status, 500);
}

TEST(HttpServer, StreamsInChunks) {
    RunningServer server({}, dictate, [](const Exchange&) {});
    const std::string answer = Client(server.port()).ask(kRequest);
    EXPECT_NE(answer.find("Transfer-Encoding: chunked\r\n"), std::string::npos) << answer;
    EXPECT_EQ(answer.find("Content-Length"), std::string::npos) << answer;
    const std::string body = "\r\n\r\n4\r\none\n\r\n18\r\ntwenty-four characters.\n\r\n0\r\n\r\n";
    EXPECT_TRUE(answer.ends_with(body)) << answer;
}

TEST(HttpServer, StreamsToHttp10ClientsUntilTheConnectionEnds) {
    RunningServer server({}, dictate, [](const Exchange&) {});
    const std::string answer = Client(server.port()).ask("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n");
    EXPECT_EQ(answer.find("Transfer-Encoding"), std::string::npos) << answer;
    EXPECT_EQ(answer.find("Content-Length"), std::string::npos) << answer;
    EXPECT_NE(answer.find("Connection: close\r\n"), std::string::npos) << answer;
    EXPECT_TRUE(answer.ends_with("\r\n\r\none\ntwenty-four characters.\n")) << answer;
}

TEST(HttpServer, StreamsNoBodyForHeadRequests) {
    RunningServer server({}, dictate, [](const Exchange&) {});
    const std::string answer = Client(server.port()).ask("HEAD / HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 200")) << answer;
    EXPECT_TRUE(answer.ends_with("\r\n\r\n")) << answer;
    EXPECT_EQ(answer.find("one"), std::string::npos) << answer;
}

TEST(HttpServer, ResetsConnectionsWhoseStreamDiffersFromItsLength) {
    for (const std::string_view piece : {"shorter", "longer than it"}) {
        const auto misjudge = [&](const Request&, const HttpResult<void>&, Connection&) {
            Response response;
            response.length = 10;
            response.stream = [&](const Send& send, Record& record) {
                record.cause = "broken";
                return send(piece);
            };
            return response;
        };
        std::atomic<int> status = 0;
        RunningServer server({}, misjudge, [&](const Exchange& exchange) { status = exchange.response.status; });
        const std::string request = "GET / HTTP/1.1\r\nHost: h\r\n\r\n";
        EXPECT_EQ(Client(server.port()).ask(request + request).find("longer"), std::string::npos);
        server.stop();
        EXPECT_EQ(status, 500) << piece;
    }
}

TEST(HttpServer, PassesHeadersOfAnyLengthToItsHandler) {
    const std::string value = "%41%0d%0a" + std::string(9'000, '%') + std::string(3'000, ' ') + "end";
    const auto echo = [](const Request& request, const HttpResult<void>&, Connection&) {
        Response response;
        for (const Header& header : request.headers) response.body += header.name + '=' + header.value + ';';
        return response;
    };
    RunningServer server({}, echo, [](const Exchange&) {});
    const std::string answer = Client(server.port())
                                   .ask("GET / HTTP/1.1\r\nHost: h\r\nConnection: close\r\nX-A: 1\r\nx-a: " + value +
                                        "\r\nX-A:2\r\nRange: bytes=0-\r\nREMOTE_ADDR: ::1\r\n\r\n");
    EXPECT_TRUE(answer.ends_with("\r\n\r\nConnection=close;Host=h;X-A=1;x-a=" + value + ";X-A=2;Range=bytes=0-;"))
        << answer;
}

TEST(HttpServer, AnswersMethodsThatTheLibraryDoesNotKnow) {
    const auto name_method = [](const Request& request, const HttpResult<void>& received, Connection&) {
        Response response;
        response.status = received ? 405 : received.error().status;
        response.body = request.method;
        return response;
    };
    for (const std::string method : {"BREW", "TRACE", "PRI", "get"}) {
        RunningServer server({}, name_method, [](const Exchange&) {});
        const std::string request = method + " / HTTP/1.1\r\nHost: h\r\nContent-Length: 0\r\n";
        const std::string answer = Client(server.port()).ask(request + "\r\n" + request + "Connection: close\r\n\r\n");
        EXPECT_TRUE(answer.starts_with("HTTP/1.1 405 ")) << answer;
        EXPECT_NE(answer.find("\r\n\r\n" + method + "HTTP/1.1 405 "), std::string::npos) << answer;
    }
}

testing::AssertionResult wait_until_gone(const Connection& connection) {
    return test::wait_until("the client to disconnect", [&] { return connection.client_gone(); });
}

TEST(HttpServer, EndsAStreamWhoseClientLeft) {
    std::promise<void> streaming;
    std::atomic<int> status = 0;
    const auto stream_on = [&](const Request&, const HttpResult<void>&, Connection& connection) {
        Response response;
        response.stream = [&](const Send& send, Record&) {
            streaming.set_value();
            EXPECT_TRUE(wait_until_gone(connection));
            EXPECT_TRUE(test::wait_until("a failure to send", [&] { return !send("more"); }));
            return false;
        };
        return response;
    };
    RunningServer server({}, stream_on, [&](const Exchange& exchange) { status = exchange.response.status; });
    {
        const Client client(server.port());
        ASSERT_TRUE(client.say(kRequest));
        ASSERT_TRUE(test::wait_for("the beginning of a stream", streaming.get_future()));
    }
    server.stop();
    EXPECT_EQ(status, 499);
}

TEST(HttpServer, LogsNoErrorForAStreamWhoseClientLeft) {
    std::promise<void> streaming;
    std::atomic<int> status = 0;
    const auto stream_on = [&](const Request&, const HttpResult<void>&, Connection& connection) {
        Response response;
        response.stream = [&](const Send&, Record&) {
            streaming.set_value();
            EXPECT_TRUE(wait_until_gone(connection));
            return false;
        };
        return response;
    };
    RunningServer server({}, stream_on, [&](const Exchange& exchange) { status = exchange.response.status; });
    {
        const Client client(server.port());
        ASSERT_TRUE(client.say(kRequest));
        ASSERT_TRUE(test::wait_for("the beginning of a stream", streaming.get_future()));
    }
    server.stop();
    EXPECT_EQ(status, 499);
}

}  // namespace
}  // namespace ccdt::server
