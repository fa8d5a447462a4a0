// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/http_library.h"

#include <httplib.h>

#include <algorithm>
#include <array>
#include <exception>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

namespace ccdt::server {
namespace {

// Limits in bytes. The library refuses lines of more than 8,192 bytes, and escapes may triple the length of a value.
constexpr std::size_t kLongestName = 1'024;
constexpr std::size_t kLongestPiece = 2'048;

/// Marks the ends of the pieces into which a long value is cut. The mark is unambiguous, because the only control
/// characters in checked values are tabs.
constexpr char kCut = '\x01';

/// Headers that the library adds to a request.
constexpr std::array<std::string_view, 4> kAdded{"REMOTE_ADDR", "REMOTE_PORT", "LOCAL_ADDR", "LOCAL_PORT"};

/// Methods that the library dispatches.
constexpr std::array<std::string_view, 7> kMethods{"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"};

bool is_range(std::string_view name) {
    return equals_ignoring_case(name, "Range");
}

/// Whether a header is hidden from the library. The library would parse Range with a regular expression, and refuse
/// long names, which the server does not use.
bool is_hidden(std::string_view name) {
    return name.size() > kLongestName || is_range(name);
}

/// Appends a header. Escapes percent signs, because the library decodes them. Cuts long values into several lines.
void append_header(std::string& head, const Header& header) {
    std::string_view rest = header.value;
    bool first = true;
    do {
        head += header.name + ':';
        if (!std::exchange(first, false)) head += kCut;
        for (const char c : rest.substr(0, kLongestPiece)) {
            head += c;
            if (c == '%') head += "25";
        }
        rest.remove_prefix(std::min(rest.size(), kLongestPiece));
        if (!rest.empty()) head += kCut;
        head += "\r\n";
    } while (!rest.empty());
}

/// Returns a head, without the query, that the library parses as parse_head() does. Returns an empty line if the
/// request has no method.
std::string head_for_library(const Request& request) {
    if (request.method.empty()) return "\r\n";
    std::string head = request.method + ' ';
    const auto path = request.resource.substr(0, request.resource.find('?'));
    head += (path.empty() ? "/" : path) + (request.is_http_1_0 ? " HTTP/1.0\r\n" : " HTTP/1.1\r\n");
    for (const Header& header : request.headers) {
        if (!is_hidden(header.name)) append_header(head, header);
    }
    return head + "\r\n";
}

/// Returns the headers that the library parsed, and joins cut values. Omits the headers that the library added.
std::vector<Header> take_headers(httplib::Headers& parsed) {
    std::vector<Header> headers;
    for (auto& [name, value] : parsed) {
        if (std::ranges::find(kAdded, name) != kAdded.end()) continue;
        if (value.ends_with(kCut)) value.pop_back();
        if (value.starts_with(kCut))
            headers.back().value += std::string_view(value).substr(1);
        else
            headers.push_back({name, std::move(value)});
    }
    return headers;
}

/// Gives cpp-httplib the checked bytes of a request, and writes to the client.
class CheckedStream : public httplib::Stream {
public:
    CheckedStream(Connection& connection, std::string head) : connection_(connection), head_(std::move(head)) {}

    /// Makes all further writes fail.
    void fail() { failed_ = true; }
    bool failed() const { return failed_; }

    bool is_readable() const override { return true; }
    bool is_writable() const override { return !failed_; }

    ssize_t read(char* target, std::size_t size) override {
        if (used_ == head_.size()) return connection_.read_content(target, size);
        const std::size_t count = head_.copy(target, size, used_);
        used_ += count;
        return static_cast<ssize_t>(count);
    }

    ssize_t write(const char* bytes, std::size_t size) override {
        failed_ = failed_ || !connection_.write({bytes, size});
        return failed_ ? -1 : static_cast<ssize_t>(size);
    }

    void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
    void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
    /// Returns no socket, because the library refuses descriptors of 1,024 or more.
    socket_t socket() const override { return -1; }

private:
    Connection& connection_;
    const std::string head_;
    std::size_t used_ = 0;
    bool failed_ = false;
};

/// A cpp-httplib server that processes one request and is then destroyed.
class RequestServer : public httplib::Server {
public:
    RequestServer(Connection& connection, Request& request, Response& response, bool& last, const Handle& handle)
        : connection_(connection),
          stream_(connection, head_for_library(request)),
          request_(request),
          response_(response),
          last_(last),
          handle_(handle) {
        svr_sock_ = 0;  // With an invalid socket, the library would send no streams.
        set_keep_alive_max_count(kRequestsPerConnection);
        set_keep_alive_timeout(std::chrono::ceil<std::chrono::seconds>(connection.patience().idle).count());
        const auto answer_plain = [this](const httplib::Request&, httplib::Response& theirs) { answer(theirs, {}); };
        const auto answer_body = [this](const httplib::Request&, httplib::Response& theirs,
                                        const httplib::ContentReader& read) {
            answer(theirs, [&read](const Connection::Receive& receive) {
                return read([&](const char* bytes, std::size_t size) { return receive({bytes, size}); });
            });
        };
        Get("/", answer_plain).Options("/", answer_plain);
        Post("/", answer_body).Put("/", answer_body).Patch("/", answer_body).Delete("/", answer_body);
        set_error_handler(HandlerWithResponse(
            [this](const httplib::Request&, httplib::Response& theirs) { return answer_refused(theirs); }));
        set_post_routing_handler(
            [this](const httplib::Request&, httplib::Response& theirs) { finish_headers(theirs); });
        // Handles lack of memory. The default handler would show the exception's text to the client.
        set_exception_handler([this](const httplib::Request&, httplib::Response& theirs, const std::exception_ptr&) {
            response_.status = theirs.status = 500;
            answered_ = last_ = true;
        });
    }

    bool process() {
        bool closed = false;
        const bool written =
            process_request(stream_, false, closed, [this](httplib::Request& theirs) { take(theirs); });
        connection_.decode_with({});
        if (stream_.failed()) response_.status = kClientGone;
        return written && !stream_.failed();
    }

private:
    /// Moves the parsed method and headers to `request_`. Leaves the library only the headers for the framing of the
    /// body, and the path `/`, because the library matches paths with regular expressions.
    void take(httplib::Request& theirs) const {
        request_.method = theirs.method;
        auto headers = take_headers(theirs.headers);
        for (Header& given : request_.headers) {
            if (is_range(given.name) && !given.value.empty()) headers.push_back(std::move(given));
        }
        request_.headers = std::move(headers);
        theirs.path = "/";
        theirs.headers.clear();
        if (request_.chunked) theirs.set_header("Transfer-Encoding", "chunked");
        if (request_.content_length) theirs.set_header("Content-Length", std::to_string(*request_.content_length));
    }

    void answer(httplib::Response& theirs, Connection::Decode decode, const HttpResult<void>& dispatched = {}) {
        answered_ = true;
        connection_.decode_with(std::move(decode));
        handle_(dispatched);
        fill(theirs);
    }

    /// Answers requests that the library refuses because of an invalid head or an unknown method.
    HandlerResponse answer_refused(httplib::Response& theirs) {
        if (answered_) return HandlerResponse::Unhandled;
        const bool expected = std::ranges::find(kMethods, request_.method) == kMethods.end();
        answer(theirs, {}, expected ? HttpResult<void>() : problem(500, "cpp-httplib refused a checked request"));
        return HandlerResponse::Handled;
    }

    void fill(httplib::Response& theirs) {
        if (response_.status == kClientGone) stream_.fail();
        theirs.status = response_.status;
        for (const auto& [name, value] : response_.headers) theirs.set_header(name, value);
        if (!response_.stream || response_.length == 0) {
            if (!response_.media_type.empty()) theirs.set_header("Content-Type", response_.media_type);
            theirs.body = std::move(response_.body);
        } else if (response_.length) {
            theirs.set_content_provider(*response_.length, response_.media_type,
                                        [this](std::size_t, std::size_t, httplib::DataSink& sink) {
                                            return send_stream(sink, *response_.length);
                                        });
        } else {
            const auto send = [this](std::size_t, httplib::DataSink& sink) {
                return send_stream(sink, std::numeric_limits<std::size_t>::max());
            };
            if (request_.is_http_1_0)
                theirs.set_content_provider(response_.media_type, send);
            else
                theirs.set_chunked_content_provider(response_.media_type, send);
        }
    }

    void finish_headers(httplib::Response& theirs) const {
        theirs.headers.erase("Accept-Ranges");
        for (const auto& [name, value] : response_.headers) {
            if (name == "Accept-Ranges") theirs.set_header(name, value);
        }
        if (theirs.status == 204 || theirs.status == 304) theirs.headers.erase("Content-Length");
        if (last_) {
            theirs.headers.erase("Keep-Alive");
            theirs.set_header("Connection", "close");
        } else if (request_.is_http_1_0) {
            theirs.set_header("Connection", "keep-alive");
        }
    }

    /// Sends a body while it is produced. A body without a known length is sent in chunks. HTTP/1.0 clients do not know
    /// chunks, so closing the connection ends such a body.
    /// @param remaining  bytes that may be sent
    /// @returns          false if the client did not receive the whole body
    bool send_stream(httplib::DataSink& sink, std::size_t remaining) {
        if (stream_.failed()) return false;
        const auto send = [&](std::string_view piece) {
            if (piece.empty()) return !stream_.failed();  // an empty chunk would end the body
            if (piece.size() > remaining || !sink.write(piece.data(), piece.size())) return false;
            remaining -= piece.size();
            return true;
        };
        const bool whole = response_.stream(send, response_.record) && (!response_.length || remaining == 0);
        if (!whole && !stream_.failed()) {
            response_.status = response_.record.cause.empty() && connection_.client_gone() ? kClientGone : 500;
            if (response_.length || request_.is_http_1_0) connection_.reset();
            return false;
        }
        if (connection_.client_gone()) stream_.fail();
        if (!response_.length && !stream_.failed()) sink.done();
        return !stream_.failed();
    }

    Connection& connection_;
    CheckedStream stream_;
    Request& request_;
    Response& response_;
    bool& last_;
    const Handle& handle_;
    bool answered_ = false;
};

}  // namespace

bool process_request(Connection& connection, Request& request, Response& response, bool& last, const Handle& handle) {
    return RequestServer(connection, request, response, last, handle).process();
}

}  // namespace ccdt::server
