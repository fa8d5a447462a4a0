// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/http.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

HttpResult<Request> parse_with(const std::string& headers, const std::string& line = "POST /a HTTP/1.1") {
    return parse_head(line + "\r\n" + headers + "\r\n");
}

TEST(ParseHead, ReadsLineAndHeaders) {
    const auto request = parse_head("POST /a%20b?x=1&y HTTP/1.1\r\nHost: h\r\nX-Thing:  a b \r\nEmpty:\r\n\r\n");
    ASSERT_TRUE(request);
    EXPECT_EQ(request->method, "POST");
    EXPECT_EQ(request->target, "/a%20b?x=1&y");
    EXPECT_EQ(request->path, "/a b");
    EXPECT_EQ(request->query, "x=1&y");
    EXPECT_EQ(request->header("x-thing"), "a b");
    EXPECT_EQ(request->header("empty"), "");
    EXPECT_EQ(request->header("missing"), "");
    EXPECT_TRUE(request->keep_alive);
    EXPECT_FALSE(request->is_framed());
}

TEST(ParseHead, FindsThePathOfAnAbsoluteUrl) {
    EXPECT_EQ(parse_with("", "GET http://host:80/health?a#b HTTP/1.1")->path, "/health");
    EXPECT_EQ(parse_with("", "GET http://host HTTP/1.1")->path, "/");
    EXPECT_EQ(parse_with("", "GET http://host?a=/b HTTP/1.1")->path, "/");
    EXPECT_EQ(parse_with("", "GET http://host?a=/b HTTP/1.1")->query, "a=/b");
    EXPECT_EQ(parse_with("", "GET HTTPS://[::1]:80/a?b HTTP/1.1")->path, "/a");
    EXPECT_EQ(parse_with("", "GET /x://y HTTP/1.1")->path, "/x://y");
    EXPECT_EQ(parse_with("", "OPTIONS * HTTP/1.1")->path, "*");
}

TEST(ParseHead, RefusesTargetsThatAreNeitherPathNorUrl) {
    for (const char* target : {"foo?x://y/metrics", "x://metrics/health/live", "foo", "?x", "*", "http",
                               "http:", "http://", "http:///health", "http://:80/health", "http://u@h/health",
                               "http:/h/health", "ftp://h/health", "https://?x"}) {
        const auto request = parse_with("", std::string("GET ") + target + " HTTP/1.1");
        ASSERT_FALSE(request) << target;
        EXPECT_EQ(request.error().status, 400) << target;
    }
    EXPECT_FALSE(parse_with("", "CONNECT h:80 HTTP/1.1"));
}

TEST(ParseHead, ReadsTheFramingOfTheBody) {
    EXPECT_EQ(parse_with("Content-Length: 12\r\n")->content_length, 12u);
    EXPECT_TRUE(parse_with("transfer-encoding: Chunked\r\n")->chunked);
    EXPECT_TRUE(parse_with("Expect: 100-continue\r\n")->expects_continue);
}

TEST(ParseHead, RefusesAmbiguousFraming) {
    for (const char* headers :
         {"Content-Length: abc\r\n", "Content-Length: 10abc\r\n", "Content-Length: -1\r\n", "Content-Length: +1\r\n",
          "Content-Length: 1, 1\r\n", "Content-Length:\r\n", "Content-Length: 99999999999999999999\r\n",
          "Content-Length: 1\r\nContent-Length: 1\r\n", "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n",
          "Transfer-Encoding: gzip, chunked\r\n", "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
          "Transfer-Encoding: identity\r\n"}) {
        const auto request = parse_with(headers);
        ASSERT_FALSE(request) << headers;
        EXPECT_EQ(request.error().status, 400);
    }
    EXPECT_FALSE(parse_with("Transfer-Encoding: chunked\r\n", "POST / HTTP/1.0"));
}

TEST(ParseHead, RefusesMalformedHeads) {
    for (const char* line : {"", "GET", "GET /", "GET  / HTTP/1.1", "GET / HTTP/2", "GET / HTTP/1.1 ", "G@T / HTTP/1.1",
                             "GET /\x01 HTTP/1.1", "GET / /b HTTP/1.1"})
        EXPECT_FALSE(parse_with("", line)) << line;
    for (const char* headers :
         {"no colon\r\n", "Name : spaced\r\n", ": unnamed\r\n", " folded\r\n", "A: b\nC: d\r\n", "A: b\x7f\r\n"})
        EXPECT_FALSE(parse_with(headers)) << headers;
    EXPECT_FALSE(parse_head("GET / HTTP/1.1\r\nA: b\r\n"));
    EXPECT_FALSE(parse_head(""));
}

TEST(ParseHead, IgnoresExpectationsOfHttp10Clients) {
    EXPECT_FALSE(parse_with("Expect: 100-continue\r\n", "POST / HTTP/1.0")->expects_continue);
}

TEST(ParseHead, RefusesALongRequestLine) {
    EXPECT_TRUE(parse_with("", "GET /" + std::string(8176, 'x') + " HTTP/1.1"));
    EXPECT_EQ(parse_with("", "GET /" + std::string(8177, 'x') + " HTTP/1.1").error().status, 414);
}

TEST(ParseHead, PrefersTheAuthorityOfAnAbsoluteUrlToHost) {
    EXPECT_EQ(parse_with("Host: a:80\r\n")->authority, "a:80");
    EXPECT_EQ(parse_with("")->authority, "");
    EXPECT_EQ(parse_with("Host: a\r\n", "GET http://b:81/health HTTP/1.1")->authority, "b:81");
    EXPECT_EQ(parse_with("Host: a\r\n", "OPTIONS * HTTP/1.1")->authority, "a");
}

TEST(CheckRequest, RequiresExactlyOneHost) {
    for (const char* host : {"h", "example.org:80", "[::1]:8080", "192.0.2.1", ""})
        EXPECT_TRUE(check_request(*parse_with("Host: " + std::string(host) + "\r\n"))) << host;
    for (const char* headers : {"", "Host: a\r\nHost: a\r\n", "Host: a b\r\n", "Host: a/b\r\n", "Host: \xff\r\n"})
        EXPECT_EQ(check_request(*parse_with(headers)).error().status, 400) << headers;
    EXPECT_TRUE(check_request(*parse_with("", "GET / HTTP/1.0")));
}

TEST(CheckRequest, RejectsRepeatedSingleFields) {
    for (const char* name :
         {"Access-Control-Request-Method", "Authorization", "Content-Type", "host", "Origin", "X-Request-ID"}) {
        const std::string line = std::string(name) + ": a\r\n";
        const std::string host = name == std::string("host") ? "" : "Host: h\r\n";
        EXPECT_TRUE(check_request(*parse_with(host + line))) << name;
        const auto checked = check_request(*parse_with(host + line + line));
        ASSERT_FALSE(checked) << name;
        EXPECT_EQ(checked.error().status, 400) << name;
        EXPECT_FALSE(check_request(*parse_with(host + line + line, "GET / HTTP/1.0"))) << name;
    }
}

TEST(CheckRequest, AcceptsRepeatedLists) {
    for (const std::string name : {"Accept", "Accept-Encoding", "Cache-Control", "Connection", "Forwarded",
                                   "If-None-Match", "Prefer", "Via", "X-Forwarded-For"})
        EXPECT_TRUE(check_request(*parse_with("Host: h\r\n" + name + ": a\r\n" + name + ": b\r\n"))) << name;
}

TEST(CheckRequest, AcceptsOnlyTheExpectationOfContinue) {
    EXPECT_TRUE(check_request(*parse_with("Host: h\r\nExpect: 100-Continue\r\n")));
    EXPECT_EQ(check_request(*parse_with("Host: h\r\nExpect: tea\r\n")).error().status, 417);
    EXPECT_TRUE(check_request(*parse_with("Expect: tea\r\n", "POST / HTTP/1.0")));
}

TEST(ParseHead, ReadsWhetherTheConnectionIsKeptAlive) {
    EXPECT_TRUE(parse_with("")->keep_alive);
    EXPECT_FALSE(parse_with("Connection: close\r\n")->keep_alive);
    EXPECT_FALSE(parse_with("Connection: foo, Close\r\n")->keep_alive);
    EXPECT_FALSE(parse_with("", "GET / HTTP/1.0")->keep_alive);
    EXPECT_TRUE(parse_with("Connection: Keep-Alive\r\n", "GET / HTTP/1.0")->keep_alive);
}

TEST(ParseQuery, KeepsOrderAndRepetitions) {
    const auto options = parse_query("b=1&a=2&b=1&&empty=&none&c=x%3Dy%26+z&bad=%zz%4");
    ASSERT_EQ(options.size(), 7u);
    EXPECT_EQ(options[0].name + options[1].name + options[2].name, "bab");
    EXPECT_EQ(options[0].value, "1");
    EXPECT_EQ(options[2].value, "1");
    EXPECT_EQ(options[3].value, "");
    EXPECT_EQ(options[4].name, "none");
    EXPECT_EQ(options[5].value, "x=y& z");
    EXPECT_EQ(options[6].value, "%zz%4");
    EXPECT_TRUE(parse_query("").empty());
}

TEST(TakeParameter, RemovesAParameterFromAQuery) {
    std::string query = "sites=3&image_url=https%3a//a.example/b%26c&x=%zz";
    EXPECT_EQ(take_parameter(query, "image_url"), "https://a.example/b&c");
    EXPECT_EQ(query, "sites=3&x=%zz");
    EXPECT_EQ(take_parameter(query, "image_url"), std::nullopt);
    EXPECT_EQ(query, "sites=3&x=%zz");
}

TEST(Prefers, FindsAPreferenceAmongOthers) {
    const auto prefers_async = [](std::string_view header) {
        Request request;
        request.headers = {{"Accept", "respond-async"}, {"prefer", std::string(header)}};
        return prefers(request, "respond-async");
    };
    for (const char* header :
         {"respond-async", "Respond-Async", "wait=10, respond-async", "respond-async;x=y, wait=10"})
        EXPECT_TRUE(prefers_async(header)) << header;
    for (const char* header : {"", "respond", "respond-asyncs", "wait=respond-async", ","})
        EXPECT_FALSE(prefers_async(header)) << header;
    Request twice;
    twice.headers = {{"Prefer", "wait=10"}, {"Prefer", "respond-async"}};
    EXPECT_TRUE(prefers(twice, "respond-async"));
}

TEST(Prefers, FindsParametersInQuotes) {
    Request request;
    request.headers = {{"Prefer", R"(respond-async, Callback; url="https://example.org/a?b=c,d;e", wait=10)"}};
    const auto callback = find_preference(request, "callback");
    ASSERT_TRUE(callback);
    EXPECT_EQ(header_parameter(*callback, "url"), "https://example.org/a?b=c,d;e");
    EXPECT_TRUE(prefers(request, "wait"));
    request.headers = {{"Prefer", R"(x="y, respond-async)"}};
    EXPECT_TRUE(prefers(request, "respond-async")) << "the quote is not closed";
}

TEST(MediaType, IsLowercaseWithoutParameters) {
    EXPECT_EQ(media_type("Application/JSON; charset=utf-8"), "application/json");
    EXPECT_EQ(media_type(""), "");
}

TEST(HeaderParameter, IsFoundPlainAndQuoted) {
    EXPECT_EQ(header_parameter("multipart/form-data; boundary=abc; x=y", "boundary"), "abc");
    EXPECT_EQ(header_parameter("multipart/form-data;Boundary=\"a;b\\\"c\" ; x=y", "boundary"), "a;b\"c");
    EXPECT_EQ(header_parameter("form-data; filename=\"name=x\"; name=\"y\"", "name"), "y");
    EXPECT_EQ(header_parameter("form-data; name=\"unclosed", "name"), "unclosed");
    EXPECT_EQ(header_parameter("boundary=abc", "boundary"), "");
    EXPECT_EQ(header_parameter("", "boundary"), "");
}

}  // namespace
}  // namespace ccdt::server
