// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/routes/routes.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>

#include "server/jobs/sqlite_job_store.h"
#include "tests/server/compute_in_process.h"
#include "tests/server/reading.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

/// Returns the answer to a request whose head was read from the connection. Handlers can read the body.
Response answer(Routes& routes, Request request, Connection& connection) {
    Response response;
    test::process_without_answer(connection, request, [&](const HttpResult<void>& dispatched) {
        response = routes.answer(request, dispatched, connection);
    });
    return response;
}

/// Passes requests directly to the routes, as if they had arrived over a connection.
class RoutesTest : public testing::Test {
protected:
    RoutesTest() { EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, sockets_.data()), 0); }
    ~RoutesTest() override {
        for (const int socket : sockets_) ::close(socket);
    }

    Response ask(const std::string& head, const HttpResult<void>& received = {}) {
        Connection connection(sockets_[0]);
        return routes_.answer(*parse_head(head + "\r\n\r\n"), received, connection);
    }

    /// Parses a request and passes it to the routes, with a connection that stays open.
    Response ask(const std::string& head, Connection& connection) {
        const std::string sent = head + "\r\n\r\n";
        EXPECT_EQ(write(sockets_[1], sent.data(), sent.size()), static_cast<ssize_t>(sent.size()));
        return answer(routes_, *connection.read_head(), connection);
    }

    static std::string header(const Response& response, std::string_view name) {
        const auto found = std::ranges::find(response.headers, name, &Header::name);
        return found == response.headers.end() ? "" : found->value;
    }

    int socket() const { return sockets_[0]; }

    Routes make(const Config& config) {
        return Routes(config,
                      {access_control_, pool_, waiting_memory_, compute_, jobs_, metrics_, [this] { return missing_; },
                       [this](const std::string& warning) { warnings_.push_back(warning); }});
    }

    Config config_;
    std::string missing_;
    std::vector<std::string> warnings_;
    WorkerPool pool_{1, 1};
    Metrics metrics_{"1.2.3"};
    Compute compute_ = test::compute_in_process(config_.limits);
    std::unique_ptr<SqliteJobStore> store_ = *SqliteJobStore::open("");
    JobService jobs_{config_.jobs, *store_, false, pool_, compute_, [](const JobEnd&) {}};
    MemoryBudget waiting_memory_{std::size_t{1} << 30};
    AccessControl access_control_{"", {}};
    Routes routes_ = make(config_);

private:
    std::array<int, 2> sockets_{};
};

TEST_F(RoutesTest, KeepsAWellFormedRequestId) {
    EXPECT_EQ(ask("GET /health HTTP/1.1\r\nX-Request-ID: aZ09._-").record.request_id, "aZ09._-");
    const std::string longest(64, 'a');
    EXPECT_EQ(ask("GET /health HTTP/1.1\r\nX-Request-ID: " + longest).record.request_id, longest);
}

TEST_F(RoutesTest, ReplacesAnyOtherRequestId) {
    for (const std::string& id : {std::string("a b"), std::string("a%0d%0aX"), std::string(65, 'a'), std::string()}) {
        const Response response = ask("GET /health HTTP/1.1\r\nX-Request-ID: " + id);
        EXPECT_NE(response.record.request_id, id);
        EXPECT_EQ(header(response, "X-Request-ID"), response.record.request_id);
    }
    EXPECT_NE(ask("GET /health HTTP/1.1").record.request_id, ask("GET /health HTTP/1.1").record.request_id);
}

TEST_F(RoutesTest, AnswersErrorsAsProblems) {
    const Response response = ask("GET /health HTTP/1.1", problem(431, "too large"));
    EXPECT_EQ(response.status, 431);
    EXPECT_EQ(response.media_type, "application/problem+json");
    EXPECT_NE(response.body.find("too large"), std::string::npos);
}

TEST_F(RoutesTest, AreNotReadyWhileSomethingIsMissing) {
    missing_ = "the kettle";
    const Response refused = ask("GET /health/ready HTTP/1.1");
    EXPECT_EQ(refused.status, 503);
    EXPECT_NE(refused.body.find("the kettle"), std::string::npos);
    EXPECT_EQ(ask("GET /health/live HTTP/1.1").status, 200);
    missing_.clear();
    EXPECT_EQ(ask("GET /health/ready HTTP/1.1").status, 200);
}

TEST_F(RoutesTest, RefusesNewWorkWhileDraining) {
    EXPECT_EQ(ask("GET /health/ready HTTP/1.1").status, 200);
    routes_.drain();
    EXPECT_EQ(ask("GET /health/ready HTTP/1.1").status, 503);
    EXPECT_EQ(ask("GET /health/live HTTP/1.1").status, 200);
    Connection connection(socket());
    EXPECT_EQ(ask("POST /halftone HTTP/1.1\r\nContent-Length: 0", connection).status, 400)
        << "whoever had connected is served";
    const Response refused = ask("POST /halftone HTTP/1.1\r\nContent-Length: 0", connection);
    EXPECT_EQ(refused.status, 503);
    EXPECT_FALSE(header(refused, "Retry-After").empty());
}

TEST_F(RoutesTest, CountsThePageAsOneRoute) {
    EXPECT_EQ(ask("GET / HTTP/1.1").record.route, "/");
    EXPECT_EQ(ask("GET /assets/main.js HTTP/1.1").record.route, "/");
    EXPECT_EQ(ask("GET /assets/nothing.js HTTP/1.1").status, 404);
    EXPECT_EQ(header(ask("POST /assets/main.js HTTP/1.1"), "Allow"), "GET, HEAD, OPTIONS");
    EXPECT_EQ(ask("GET /openapi.json HTTP/1.1").record.route, "/openapi.json");
}

TEST_F(RoutesTest, RequireAKeyExceptForThePageAndHealthChecks) {
    const std::string file = testing::TempDir() + "ccdt_keys_of_routes_" + std::to_string(::getpid());
    std::ofstream(file) << "alice:0123456789abcdef";
    AccessControl access_control(file, {.per_second = 0.001, .burst = 1000});
    ASSERT_TRUE(access_control.read_keys());
    std::filesystem::remove(file);
    Routes routes(config_, {access_control, pool_, waiting_memory_, compute_, jobs_, metrics_, [] { return ""; }, {}});
    const auto status = [&](const std::string& line, const std::string& headers = "") {
        Connection connection(socket());
        return routes.answer(*parse_head(line + " HTTP/1.1\r\n" + headers + "\r\n"), {}, connection).status;
    };
    for (const char* line : {"GET /", "HEAD /", "GET /assets/main.js", "GET /openapi.json", "GET /health",
                             "HEAD /health/ready", "GET /health/live"})
        EXPECT_EQ(status(line), 200) << line;
    EXPECT_EQ(status("OPTIONS /health"), 204);
    EXPECT_EQ(status("POST /health"), 405);
    EXPECT_EQ(status("GET /health/nothing"), 404);
    for (const char* line :
         {"POST /", "OPTIONS /", "GET /assets/", "GET /assets/nothing.js", "GET /healthy", "GET /metrics",
          "GET /jobs/a", "DELETE /jobs/a", "GET /jobs/a/events", "POST /halftone", "GET /halftone/a",
          "POST /halftone/a", "POST /sample", "POST /analyze", "OPTIONS /halftone", "OPTIONS *", "GET /nothing"})
        EXPECT_EQ(status(line), 401) << line;
    EXPECT_EQ(status("GET /metrics", "Authorization: Bearer 0123456789abcdef\r\n"), 200);

    Connection connection(socket());
    const auto with_key = parse_head("GET /metrics HTTP/1.1\r\nAuthorization: Bearer 0123456789abcdef\r\n\r\n");
    EXPECT_EQ(routes.answer(*with_key, {}, connection).record.key, "alice");
    EXPECT_EQ(routes.answer({}, problem(400, "malformed"), connection).record.key, "") << "is not the last one's";
}

TEST_F(RoutesTest, AcceptOnePathComponentAsAName) {
    const auto route = [&](const std::string& target) {
        return std::string(ask("GET " + target + " HTTP/1.1").record.route);
    };
    for (const char* target : {"/halftone/a", "/halftone/a.b", "/halftone/%00", "/halftone/..", "/halftone/{name}",
                               "/halftone/a?b/c", "/halftone/%2e%2e"})
        EXPECT_EQ(route(target), "/halftone/{name}") << target;
    for (const char* target : {"/halftone/", "/halftone//", "/halftone/a/", "/halftone/a/b", "/halftone/..%2fa",
                               "/halftones/a", "/x/halftone/a"})
        EXPECT_EQ(route(target), "") << target;
    EXPECT_EQ(route("/jobs/a"), "/jobs/{id}");
    EXPECT_EQ(route("/jobs/a/result"), "/jobs/{id}/result");
    EXPECT_EQ(route("/tiles/a.json"), "/tiles/{id}.json");
    EXPECT_EQ(route("/tiles/a/0/1/2.mvt"), "/tiles/{id}/{z}/{x}/{y}.mvt");
    for (const char* target :
         {"/tiles/a", "/tiles/.json", "/tiles/a/b.json", "/tiles/a/0/1.mvt", "/tiles/a/0/1/2/3.mvt"})
        EXPECT_EQ(route(target), "") << target;
    for (const char* target : {"/jobs/", "/jobs//result", "/jobs/a/", "/jobs/a/results", "/jobs/a/b/result", "/jobs"})
        EXPECT_EQ(route(target), "") << target;
}

TEST_F(RoutesTest, AcceptAnyPathOfADocument) {
    for (const char* target : {"/docs/", "/docs/a", "/docs/a/b", "/docs//", "/docs/..%2fa", "/docs/{path}"})
        EXPECT_EQ(ask("GET " + std::string(target) + " HTTP/1.1").record.route, "/docs/{path}") << target;
    for (const char* target : {"/docs", "/document/a", "/x/docs/a"})
        EXPECT_EQ(ask("GET " + std::string(target) + " HTTP/1.1").record.route, "") << target;
}

TEST_F(RoutesTest, ServeDocumentsOnlyFromAFolder) {
    const Response refused = ask("GET /docs/ HTTP/1.1");
    EXPECT_EQ(refused.status, 404);
    EXPECT_NE(refused.body.find("(docs)"), std::string::npos) << refused.body;
}

TEST_F(RoutesTest, ServeNoPicturesWithoutAFolder) {
    const Response refused = ask("GET /halftone/cat.jpg HTTP/1.1");
    EXPECT_EQ(refused.status, 404);
    EXPECT_NE(refused.body.find("(pictures)"), std::string::npos) << refused.body;
}

TEST_F(RoutesTest, ListTheMethodsOfAPath) {
    const auto allowed = [&](const std::string& path) { return header(ask("OPTIONS " + path + " HTTP/1.1"), "Allow"); };
    EXPECT_EQ(allowed("/"), "GET, HEAD, OPTIONS");
    EXPECT_EQ(allowed("/halftone"), "POST, OPTIONS");
    EXPECT_EQ(allowed("/halftone/cat.jpg"), "GET, HEAD, OPTIONS");
    EXPECT_EQ(allowed("/docs/a/b"), "GET, HEAD, OPTIONS");
    EXPECT_EQ(allowed("/jobs/a"), "GET, HEAD, DELETE, OPTIONS");
    EXPECT_EQ(allowed("/jobs/a/result"), "GET, HEAD, OPTIONS");
    EXPECT_EQ(header(ask("PUT /sample HTTP/1.1"), "Allow"), "POST, OPTIONS");
    EXPECT_EQ(ask("PUT /sample HTTP/1.1").status, 405);
}

/// Tests deadlines, with computations that the test ends, and clients that send requests concurrently.
class DeadlineTest : public RoutesTest {
protected:
    DeadlineTest() {
        config_.timeout = std::chrono::seconds(1);
        compute_ = [this](const ComputeRequest& request, const Delivery&, const Control& control, api::Timings&) {
            return request.body.find("partial") != std::string::npos ? compute_part(control) : compute_nothing();
        };
    }

    /// Stops when requested, but returns its answer only after the other request has been answered.
    Result<api::Answer> compute_part(const Control& control) {
        begun_.set_value();
        std::promise<void> stopped;
        const std::stop_callback tell(control.stop, [&stopped] { stopped.set_value(); });
        EXPECT_TRUE(test::wait_for("a request to stop", stopped.get_future()));
        EXPECT_TRUE(test::wait_for("the other answer", other_answered_.get_future()));
        api::Answer answer;
        answer.partial = true;
        return answer;
    }

    /// Ignores requests to stop.
    Result<api::Answer> compute_nothing() {
        EXPECT_TRUE(test::wait_for("the end of the test", over_.get_future()));
        return failure(ErrorCode::Stopped, "stopped");
    }

    static int status(Routes& routes, const std::string& body) {
        std::array<int, 2> sockets{};
        EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, sockets.data()), 0);
        EXPECT_EQ(write(sockets[1], body.data(), body.size()), static_cast<ssize_t>(body.size()));
        Connection connection(sockets[0]);
        const auto request =
            parse_head("POST /sample HTTP/1.1\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n");
        const int found = answer(routes, *request, connection).status;
        for (const int socket : sockets) ::close(socket);
        return found;
    }

    std::promise<void> begun_, other_answered_, over_;
};

TEST_F(DeadlineTest, GrantsTimeBeyondItForPartialAnswersOnly) {
    WorkerPool pool(2, 2);
    Routes routes(config_, {access_control_, pool, waiting_memory_, compute_, jobs_, metrics_, [] { return ""; }, {}});
    const std::string common = R"({"sites":1000,"domain":{"type":"rectangle","width":1,"height":1})";
    auto partial =
        std::async(std::launch::async, [&] { return status(routes, common + R"(,"on_deadline":"partial"})"); });
    ASSERT_TRUE(test::wait_for("the beginning of a computation", begun_.get_future()));
    EXPECT_EQ(status(routes, common + '}'), 504);
    other_answered_.set_value();
    EXPECT_EQ(partial.get(), 200) << "the other request, which began later, was answered first";
    over_.set_value();
    pool.drain();
}

TEST_F(RoutesTest, SendsNoCorsHeadersUnlessConfigured) {
    EXPECT_EQ(header(ask("GET /health HTTP/1.1"), "Access-Control-Allow-Origin"), "");
}

TEST_F(RoutesTest, AllowsTheConfiguredOrigin) {
    Config config;
    config.live.cors_origins = {"https://example.org"};
    Routes routes = make(config);
    Connection connection(-1);
    const auto request = parse_head(
        "OPTIONS /halftone HTTP/1.1\r\nOrigin: https://example.org\r\nAccess-Control-Request-Method: POST\r\n\r\n");
    const Response response = routes.answer(*request, {}, connection);
    EXPECT_EQ(response.status, 204);
    EXPECT_EQ(header(response, "Access-Control-Allow-Origin"), "https://example.org");
    EXPECT_EQ(header(response, "Access-Control-Allow-Methods"), "POST, OPTIONS");
    EXPECT_EQ(header(response, "Vary"), "Origin");
}

TEST_F(RoutesTest, RefusesHostsThatAreNotAllowed) {
    config_.live.allowed_hosts = {"dots.example", "loopback"};
    Routes routes = make(config_);
    Connection connection(socket());
    const auto status = [&](const std::string& head) {
        const Response response = routes.answer(*parse_head(head + "\r\n\r\n"), {}, connection);
        EXPECT_TRUE(response.status != 421 || response.media_type == "application/problem+json") << head;
        return response.status;
    };
    for (const char* path : {"/capabilities", "/", "/metrics", "/nothing", "/jobs/1", "/halftone", "/halftone/a"}) {
        const std::string line = "GET " + std::string(path) + " HTTP/1.1\r\nHost: ";
        EXPECT_EQ(status(line + "evil.example:8080"), 421) << path;
        EXPECT_NE(status(line + "localhost:8080"), 421) << path;
        EXPECT_NE(status(line + "dots.example"), 421) << path;
    }
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_NE(warnings_.front().find("evil.example:8080"), std::string::npos);
    EXPECT_EQ(status("OPTIONS /halftone HTTP/1.1\r\nHost: evil.example"), 421);
    EXPECT_EQ(status("GET http://evil.example/ HTTP/1.1\r\nHost: localhost"), 421);
    EXPECT_EQ(status("GET / HTTP/1.0"), 200) << "browsers name a host";
    EXPECT_EQ(status("GET /health/live HTTP/1.1\r\nHost: balancer"), 200) << "health checks may name any";
}

TEST_F(RoutesTest, WarnsOnceAboutRefusedOrigins) {
    const std::string preflight =
        "OPTIONS /halftone HTTP/1.1\r\nAccess-Control-Request-Method: POST\r\nOrigin: http://localhost:5500";
    ask("GET /health HTTP/1.1\r\nOrigin: http://localhost:5500");
    ask("POST /sample HTTP/1.1\r\nOrigin: http://h\r\nSec-Fetch-Mode: cors\r\nSec-Fetch-Site: same-origin");
    EXPECT_TRUE(warnings_.empty()) << "may be a page of our own";
    EXPECT_EQ(header(ask(preflight), "Access-Control-Allow-Methods"), "");
    ask(preflight);
    ask("POST /sample HTTP/1.1\r\nOrigin: http://h\r\nSec-Fetch-Mode: cors\r\nSec-Fetch-Site: cross-site");
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_NE(warnings_.front().find("--cors-origin http://localhost:5500 would"), std::string::npos);
}

TEST_F(RoutesTest, CompressesLongTextsOnRequest) {
    const std::string detail(2000, 'x');
    const Response plain = ask("GET /health HTTP/1.1", problem(400, detail));
    EXPECT_EQ(header(plain, "Content-Encoding"), "");
    EXPECT_EQ(header(plain, "Vary"), "Accept-Encoding");
    const Response small = ask("GET /health HTTP/1.1\r\nAccept-Encoding: gzip", problem(400, detail));
    EXPECT_EQ(header(small, "Content-Encoding"), "gzip");
    EXPECT_LT(small.body.size(), 500u);
    EXPECT_EQ(header(ask("GET /health HTTP/1.1\r\nAccept-Encoding: gzip"), "Vary"), "");
}

TEST_F(RoutesTest, GivesEachCodingItsOwnTag) {
    const std::string plain = header(ask("GET / HTTP/1.1"), "ETag");
    const std::string packed = header(ask("GET / HTTP/1.1\r\nAccept-Encoding: gzip"), "ETag");
    EXPECT_EQ(packed, plain.substr(0, plain.size() - 1) + "-gzip\"");
    for (const std::string& tag : {plain, packed}) {
        const Response response = ask("GET / HTTP/1.1\r\nAccept-Encoding: gzip\r\nIf-None-Match: " + tag);
        EXPECT_EQ(response.status, 304);
        EXPECT_EQ(header(response, "ETag"), tag);
        EXPECT_EQ(header(response, "Vary"), "Accept-Encoding");
        EXPECT_EQ(header(response, "Content-Encoding"), "");
    }
}

TEST_F(RoutesTest, SendsPingsInEventStreams) {
    Config config;
    config.jobs.ping = std::chrono::milliseconds(1);
    Routes routes = make(config);
    const auto job = jobs_.accept({}, {"/sample", "", "", "", "{}"});  // stays queued, because start() was not called
    Connection connection(socket());
    const auto request = parse_head("GET /jobs/" + job->id + "/events HTTP/1.1\r\n\r\n");
    const Response response = routes.answer(*request, {}, connection);
    EXPECT_EQ(response.media_type, "text/event-stream");
    EXPECT_EQ(header(response, "X-Accel-Buffering"), "no");
    std::string sent;
    Record record;
    response.stream(
        [&](std::string_view piece) {
            sent += piece;
            return !sent.ends_with(": ping\n\n: ping\n\n");
        },
        record);
    EXPECT_TRUE(sent.starts_with("event: progress\ndata: {\"id\":\"" + job->id)) << sent;
}

TEST_F(RoutesTest, AssignsConnectionsToTheirClass) {
    const auto job = jobs_.accept({}, {"/sample", "", "", "", "{}"});
    const auto is_answered = [&](const Capacity::Limits& limits, const std::string& path) {
        Capacity capacity(limits);
        ConnectionSlot slot(capacity, "a");
        Connection connection(socket(), {}, &capacity, &slot);
        const auto request = parse_head("GET " + path + " HTTP/1.1\r\n\r\n");
        const Response response = routes_.answer(*request, {}, connection);
        EXPECT_EQ(header(response, "Retry-After"), response.status == 503 ? "1" : "");
        return response.status == 200;
    };
    const Capacity::Limits common{.connections = 1, .reserve = 0, .streams = 0};
    const Capacity::Limits reserve{.connections = 0, .reserve = 1, .streams = 0};
    const Capacity::Limits streams{.connections = 0, .reserve = 1, .streams = 1};
    for (const char* path : {"/health", "/health/live", "/health/ready", "/metrics"}) {
        EXPECT_TRUE(is_answered(common, path)) << path;
        EXPECT_TRUE(is_answered(reserve, path)) << path;
    }
    for (const std::string& path : {std::string("/"), std::string("/openapi.json"), "/jobs/" + job->id}) {
        EXPECT_TRUE(is_answered(common, path)) << path;
        EXPECT_FALSE(is_answered(reserve, path)) << path;
        EXPECT_FALSE(is_answered(streams, path)) << path;
    }
    EXPECT_TRUE(is_answered(streams, "/jobs/" + job->id + "/events"));
    EXPECT_FALSE(is_answered(common, "/jobs/" + job->id + "/events"));
    EXPECT_FALSE(is_answered(reserve, "/jobs/" + job->id + "/events"));
}

}  // namespace
}  // namespace ccdt::server
