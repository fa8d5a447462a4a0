// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/connection.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <thread>

#include "tests/server/reading.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

bool never(std::chrono::milliseconds) {
    return false;
}

/// A Connection, and the client's end of its socket.
class Pair {
public:
    explicit Pair(const Patience& patience = {}, Capacity* capacity = nullptr)
        : connection_(make(), patience, capacity) {}
    ~Pair() {
        ::close(sockets_[0]);
        hang_up();
    }
    Pair(const Pair&) = delete;
    Pair& operator=(const Pair&) = delete;

    Connection& connection() { return connection_; }

    void send(std::string_view bytes) {
        ASSERT_EQ(::send(sockets_[1], bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    }

    std::string receive() {
        std::array<char, 1024> buffer{};
        const ssize_t size = ::recv(sockets_[1], buffer.data(), buffer.size(), MSG_DONTWAIT);
        return {buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
    }

    void hang_up() {
        if (sockets_[1] >= 0) ::close(sockets_[1]);
        sockets_[1] = -1;
    }

    HttpResult<std::string> read(std::string_view request, std::size_t limit = 100) {
        send(request);
        EXPECT_TRUE(connection_.wait_for_request(never));
        auto head = connection_.read_head();
        if (!head) return tl::unexpected(head.error());
        return test::read_body(connection_, *std::move(head), limit);
    }

private:
    int make() {
        EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, sockets_.data()), 0);
        return sockets_[0];
    }

    std::array<int, 2> sockets_{-1, -1};
    Connection connection_;
};

int status_of(const HttpResult<std::string>& body) {
    return body ? 200 : body.error().status;
}

constexpr const char* kChunked = "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n";

TEST(Connection, ReadsABodyWithContentLength) {
    Pair pair;
    EXPECT_EQ(pair.read("POST / HTTP/1.1\r\nContent-Length: 5\r\n\r\nhello"), "hello");
    EXPECT_TRUE(pair.connection().between_requests());
}

TEST(Connection, ReadsAChunkedBody) {
    Pair pair;
    EXPECT_EQ(pair.read(std::string(kChunked) + "5\r\nhello\r\n1;x=y\r\n!\r\nA\r\n0123456789\r\n0\r\nT: r\r\n\r\n"),
              "hello!0123456789");
    EXPECT_TRUE(pair.connection().between_requests());
}

TEST(Connection, KeepsPipelinedRequests) {
    Pair pair;
    pair.send("POST /2 HTTP/1.1\r\nContent-Length: 1\r\n\r\nb\r\nGET /3 HTTP/1.1\r\n\r\n");
    EXPECT_EQ(pair.read(""), "b");
    ASSERT_TRUE(pair.connection().wait_for_request(never));
    EXPECT_EQ(pair.connection().read_head()->path, "/3");
    EXPECT_TRUE(pair.connection().between_requests());
}

TEST(Connection, RefusesAnAnnouncedBodyOverTheLimitWithoutReadingIt) {
    Pair pair;
    EXPECT_EQ(status_of(pair.read("POST / HTTP/1.1\r\nContent-Length: 101\r\n\r\n")), 413);
    EXPECT_FALSE(pair.connection().between_requests());
}

TEST(Connection, CountsChunksAgainstTheLimit) {
    EXPECT_EQ(status_of(Pair().read(std::string(kChunked) + "40\r\n" + std::string(64, 'x') + "\r\n25\r\n")), 413);
    EXPECT_EQ(status_of(Pair().read(std::string(kChunked) + "ffffffffffffffff\r\n")), 413);
    EXPECT_EQ(Pair().read(std::string(kChunked) + "64\r\n" + std::string(100, 'x') + "\r\n0\r\n\r\n")->size(), 100u);
}

TEST(Connection, RefusesMalformedChunks) {
    for (const char* chunks :
         {"x\r\n", "-1\r\n", "\r\n", "0x1\r\na\r\n", "1 \r\na\r\n", "1\r\nab\r\n", "10000000000000000\r\n"})
        EXPECT_EQ(status_of(Pair().read(std::string(kChunked) + chunks)), 400) << chunks;
    EXPECT_EQ(status_of(Pair().read(kChunked + std::string(5000, '0'))), 400);
}

TEST(Connection, ReadsChunksHoweverTheyArrive) {
    const std::string body =
        "5 ; a = \"b\\\"; c\" ;d=e\r\nhe\r\n!\r\n00000000001;x\r\n\n\r\n0;last\r\nX-Digest:\ta\r\nEmpty:\r\n\r\n";
    for (std::size_t cut = 1; cut < body.size(); ++cut) {
        Pair pair;
        pair.send(kChunked + body.substr(0, cut));
        ASSERT_TRUE(pair.connection().wait_for_request(never));
        const auto head = pair.connection().read_head();
        ASSERT_TRUE(head);
        pair.send(body.substr(cut));
        EXPECT_EQ(test::read_body(pair.connection(), *head, 100), "he\r\n!\n") << cut;
        EXPECT_TRUE(pair.connection().between_requests());
    }
}

/// Returns the status and message of an error; empty if the body was accepted.
std::string detail_of(const HttpResult<std::string>& body) {
    return body ? "" : std::to_string(body.error().status) + ' ' + body.error().error.message;
}

TEST(Connection, RefusesAmbiguousChunkLines) {
    using std::string_view_literals::operator""sv;
    for (const auto line : {"1\n"sv, "1;a\n\r\n"sv, "1;a\rb\r\n"sv, "1;a\0\r\n"sv, "1\r\r\n"sv, "1;a=\"\n\"\r\n"sv})
        EXPECT_EQ(detail_of(Pair().read(kChunked + std::string(line) + "x\r\n0\r\n\r\n")),
                  "400 a line does not end in CRLF, or contains a NUL")
            << line;
    for (const auto line :
         {"1;"sv, "1 a"sv, "1;;a"sv, "1;a="sv, "1;a=\"b"sv, "1;a=\"b\"c"sv, "1;a=\x01"sv, "1;a=\"\\\x01\""sv,
          "1;\xe9"sv, "1;a b"sv, "1;a "sv, ";a"sv, " 1"sv, "+1"sv, "00000000000000001"sv})
        EXPECT_EQ(status_of(Pair().read(kChunked + std::string(line) + "\r\nx\r\n0\r\n\r\n")), 400) << line;
}

TEST(Connection, RefusesInvalidTrailers) {
    using std::string_view_literals::operator""sv;
    for (const auto trailer : {"nonsense"sv, ": a"sv, "A : b"sv, " folded"sv, "A: b\nC: d"sv, "A: b\rC"sv, "A: \0"sv,
                               "A: \x01"sv, "Content-Length: 5"sv, "transfer-encoding: chunked"sv, "HOST: h"sv,
                               "Authorization: Bearer x"sv, "Content-Type: text/plain"sv, "GET /metrics HTTP/1.1"sv})
        EXPECT_EQ(status_of(Pair().read(std::string(kChunked) + "0\r\n" + std::string(trailer) + "\r\n\r\n")), 400)
            << trailer;
    EXPECT_EQ(status_of(Pair().read(std::string(kChunked) + "0\r\n\n")), 400);
}

TEST(Connection, RefusesAHeadAtTheFirstLineWithoutCrlf) {
    using std::string_view_literals::operator""sv;
    for (const auto begun : {"GET / HTTP/1.1\n"sv, "\n"sv, "\r\r"sv, "GET / HTTP/1.1\r\nHost: h\n"sv,
                             "GET / HTTP/1.1\r\nA: b\rC"sv, "GET / HTTP/1.1\r\nA: \0"sv}) {
        Pair pair;
        pair.send(begun);
        ASSERT_TRUE(pair.connection().wait_for_request(never));
        const auto head = pair.connection().read_head();
        ASSERT_FALSE(head) << begun;
        EXPECT_EQ(head.error().status, 400) << begun;
    }
}

TEST(Connection, RequiresALength) {
    EXPECT_EQ(status_of(Pair().read("POST / HTTP/1.1\r\n\r\n")), 411);
    EXPECT_EQ(Pair().read("POST / HTTP/1.1\r\nContent-Length: 0\r\n\r\n"), "");
}

TEST(Connection, RefusesALargeHead) {
    const std::string line = "A: " + std::string(1000, 'x') + "\r\n";
    std::string head = "GET / HTTP/1.1\r\n";
    for (int i = 0; i < 40; ++i) head += line;
    Pair pair;
    EXPECT_EQ(status_of(pair.read(head + "\r\n")), 431);
    EXPECT_FALSE(pair.connection().between_requests());
}

TEST(Connection, SendsContinueOnlyIfTheBodyIsWanted) {
    const std::string expecting = "POST / HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: ";
    Pair unwanted;
    EXPECT_EQ(status_of(unwanted.read(expecting + "101\r\n\r\n")), 413);
    EXPECT_EQ(unwanted.receive(), "");

    Pair wanted;
    wanted.send(expecting + "2\r\n\r\n");
    ASSERT_TRUE(wanted.connection().wait_for_request(never));
    const auto head = wanted.connection().read_head();
    ASSERT_TRUE(head);
    std::jthread client([&] {
        EXPECT_TRUE(
            test::wait_until("100 Continue", [&] { return wanted.receive() == "HTTP/1.1 100 Continue\r\n\r\n"; }));
        wanted.send("ok");
    });
    EXPECT_EQ(test::read_body(wanted.connection(), *head, 100), "ok");
}

TEST(Connection, DetectsThatTheClientLeft) {
    Pair pair;
    EXPECT_FALSE(pair.connection().client_gone());
    pair.hang_up();
    EXPECT_TRUE(pair.connection().client_gone());
    EXPECT_FALSE(pair.connection().wait_for_request(never));
}

TEST(Connection, StopsWaitingOnRequest) {
    Pair pair;
    int asked = 0;
    EXPECT_FALSE(pair.connection().wait_for_request([&](std::chrono::milliseconds) { return ++asked == 2; }));
    EXPECT_EQ(asked, 2);
}

TEST(Connection, RefusesATruncatedRequest) {
    Pair pair;
    pair.send("POST / HTTP/1.1\r\nContent-Le");
    pair.hang_up();
    ASSERT_TRUE(pair.connection().wait_for_request(never));
    EXPECT_EQ(pair.connection().read_head().error().status, 400);
}

TEST(Connection, RefusesChunksThatAreMostlyFraming) {
    std::string chunks;
    for (int i = 0; i < 100; ++i) chunks += "1;" + std::string(1000, 'x') + "\r\na\r\n";
    EXPECT_EQ(status_of(Pair().read(kChunked + chunks, 1000)), 400);
    chunks.clear();
    for (int i = 0; i < 900; ++i) chunks += "1\r\na\r\n";
    EXPECT_EQ(Pair().read(kChunked + chunks + "0\r\n\r\n", 1000)->size(), 900u);
}

TEST(Connection, TimesOutOnAStalledBody) {
    Pair pair(Patience{.body = std::chrono::milliseconds(50)});
    EXPECT_EQ(status_of(pair.read("POST / HTTP/1.1\r\nContent-Length: 5\r\n\r\nhell")), 408);
    EXPECT_FALSE(pair.connection().between_requests());
}

TEST(Connection, TimesOutOnAnAnswerThatIsNotRead) {
    Pair pair(Patience{.body = std::chrono::milliseconds(50)});
    EXPECT_FALSE(pair.connection().write(std::string(50'000'000, 'x')));
    EXPECT_GT(pair.connection().bytes_out(), 0u);
}

TEST(Connection, RefusesABodyWithoutMemoryForIt) {
    Capacity capacity({.bytes = 100'000});
    CountedBytes others(&capacity);
    others.resize(60'000);
    const std::string small(30'000, 'x');
    const std::string large(90'000, 'x');
    const auto request = [](const std::string& body) {
        return "POST / HTTP/1.1\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
    };
    EXPECT_EQ(status_of(Pair({}, &capacity).read(request(small), 1'000'000)), 200);
    Pair refused({}, &capacity);
    EXPECT_EQ(status_of(refused.read(request(large), 1'000'000)), 503);
    EXPECT_FALSE(capacity.is_out_of_memory()) << "what was read is let go";
}

TEST(Connection, CountsTheBytesOfARequest) {
    Pair pair;
    const std::string request = std::string(kChunked) + "2\r\nhi\r\n0\r\n\r\n";
    ASSERT_TRUE(pair.read(request + "GET / HTTP/1.1\r\n\r\n"));
    ASSERT_TRUE(pair.connection().write("answer"));
    EXPECT_EQ(pair.connection().bytes_in(), request.size());
    EXPECT_EQ(pair.connection().bytes_out(), 6u);
}

}  // namespace
}  // namespace ccdt::server
