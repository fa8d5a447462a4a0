// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/answer_writer.h"

#include <httplib.h>

#include <exception>
#include <string>
#include <string_view>
#include <utility>

namespace ccdt::server {
namespace {

/// A stream that gives cpp-httplib one line to read, and writes to the client.
class ClientStream : public httplib::Stream {
public:
    ClientStream(Connection& connection, bool is_head)
        : connection_(connection), line_(is_head ? "HEAD / HTTP/1.1\r\n\r\n" : "GET / HTTP/1.1\r\n\r\n") {}

    bool is_readable() const override { return true; }
    bool is_writable() const override { return true; }

    ssize_t read(char* target, std::size_t size) override {
        const std::size_t count = line_.copy(target, size);
        line_.remove_prefix(count);
        return static_cast<ssize_t>(count);
    }

    ssize_t write(const char* bytes, std::size_t size) override {
        return connection_.write({bytes, size}) ? static_cast<ssize_t>(size) : -1;
    }

    void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
    void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
    socket_t socket() const override { return -1; }

private:
    Connection& connection_;
    std::string_view line_;
};

void erase_header(httplib::Response& response, const char* name) {
    response.headers.erase(name);
}

}  // namespace

class AnswerWriter::Writer : public httplib::Server {
public:
    Writer(Connection& connection, std::chrono::milliseconds idle, std::size_t requests) : connection_(connection) {
        set_keep_alive_max_count(requests);
        set_keep_alive_timeout(std::chrono::ceil<std::chrono::seconds>(idle).count());
        set_pre_routing_handler([this](const httplib::Request&, httplib::Response& theirs) {
            fill(theirs);
            return HandlerResponse::Handled;
        });
        set_post_routing_handler(
            [this](const httplib::Request&, httplib::Response& theirs) { leave_out_headers(theirs); });
        // The default handler would reveal the exception's text to the client.
        set_exception_handler([this](const httplib::Request&, httplib::Response& theirs, const std::exception_ptr&) {
            theirs.status = 500;
            failed_ = true;
        });
    }

    bool write(const Request& request, Response& response, bool& last) {
        request_ = &request;
        response_ = &response;
        failed_ = false;
        ClientStream stream(connection_, request.method == "HEAD");
        bool closed = false;
        const bool written = process_request(stream, last, closed, nullptr);
        last = last || failed_;
        return written;
    }

private:
    void fill(httplib::Response& theirs) {
        theirs.status = response_->status;
        for (const auto& [name, value] : response_->headers) theirs.set_header(name, value);
        if (!response_->media_type.empty()) theirs.set_header("Content-Type", response_->media_type);
        theirs.body = std::move(response_->body);
    }

    void leave_out_headers(httplib::Response& theirs) const {
        erase_header(theirs, "Accept-Ranges");
        const bool streams = static_cast<bool>(response_->stream);
        if (theirs.status == 204 || theirs.status == 304 || streams) erase_header(theirs, "Content-Length");
        if (streams && response_->length)
            theirs.set_header("Content-Length", std::to_string(*response_->length));
        else if (streams && !request_->is_http_1_0)
            theirs.set_header("Transfer-Encoding", "chunked");
        if (failed_) erase_header(theirs, "Keep-Alive");
        if (failed_ && !theirs.has_header("Connection")) theirs.set_header("Connection", "close");
        if (request_->is_http_1_0 && !theirs.has_header("Connection")) theirs.set_header("Connection", "keep-alive");
    }

    Connection& connection_;
    const Request* request_ = nullptr;  ///< the request that is being answered
    Response* response_ = nullptr;
    bool failed_ = false;
};

AnswerWriter::AnswerWriter(Connection& connection, std::chrono::milliseconds idle, std::size_t requests)
    : writer_(std::make_unique<Writer>(connection, idle, requests)) {}

AnswerWriter::~AnswerWriter() = default;

bool AnswerWriter::write(const Request& request, Response& response, bool& last) {
    return writer_->write(request, response, last);
}

}  // namespace ccdt::server
