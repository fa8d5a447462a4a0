#include "server/http_server.h"

#include <httplib.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

namespace ccdt::server {
namespace {

using std::chrono::milliseconds;

constexpr int kBacklog = 1024;
constexpr std::size_t kRequestsPerConnection = 10'000;
constexpr std::time_t kKeepAliveSeconds = 60;
constexpr std::time_t kWriteSeconds = 30;  ///< longest pause in which a client takes nothing

/// A connection without a request makes room after this long if others wait for a thread or the server drains.
constexpr milliseconds kIdleUnderPressure{500};

using Clock = std::chrono::steady_clock;

/// The request that this thread is answering. cpp-httplib passes nothing of ours to its hooks.
struct Answering {
    Connection& connection;
    Request request;
    std::optional<Fault> fault;
    Response response;
    bool last = false;  ///< no further request on this connection
};
thread_local Answering* answering = nullptr;

/// What cpp-httplib reads is a head without headers, whatever the client sent: we have read the request ourselves.
/// That takes its own reading of ranges, encodings, lengths and forms out of play. What it writes goes to the client.
class AnswerStream : public httplib::Stream {
public:
    explicit AnswerStream(Answering& current)
        : current_(current),
          head_(current.request.method == "HEAD" ? "HEAD / HTTP/1.1\r\n\r\n" : "GET / HTTP/1.1\r\n\r\n") {}

    bool is_readable() const override { return true; }
    bool is_writable() const override { return true; }

    ssize_t read(char* target, std::size_t size) override {
        const std::size_t count = head_.copy(target, size);
        head_.remove_prefix(count);
        return static_cast<ssize_t>(count);
    }

    ssize_t write(const char* bytes, std::size_t size) override {
        const bool written = current_.response.deliver && current_.connection.write({bytes, size});
        return written ? static_cast<ssize_t>(size) : -1;
    }

    void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
    void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
    socket_t socket() const override { return -1; }

private:
    Answering& current_;
    std::string_view head_;
};

/// Knows how many connections wait for a thread.
class ConnectionThreads : public httplib::ThreadPool {
public:
    ConnectionThreads(std::size_t threads, std::atomic<int>& waiting) : ThreadPool(threads), waiting_(waiting) {}

    void enqueue(std::function<void()> serve) override {
        ++waiting_;
        ThreadPool::enqueue([this, serve = std::move(serve)] {
            --waiting_;
            serve();
        });
    }

private:
    std::atomic<int>& waiting_;
};

class Counted {
public:
    explicit Counted(std::atomic<int>& count) : count_(count) { ++count_; }
    ~Counted() { --count_; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;

private:
    std::atomic<int>& count_;
};

void erase_header(httplib::Response& response, const char* name) {
    response.headers.erase(name);
}

}  // namespace

class HttpServer::Listener : public httplib::Server {
public:
    Listener(std::size_t threads, HttpServer::Handler handler, HttpServer::Logger logger)
        : handler_(std::move(handler)), logger_(std::move(logger)) {
        new_task_queue = [this, threads] { return new ConnectionThreads(threads, waiting_); };
        // Its default is SO_REUSEPORT, with which a second instance starts and takes half of the clients.
        set_socket_options([](socket_t socket) {
            const int yes = 1;
            setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
        });
        set_tcp_nodelay(true);
        set_keep_alive_max_count(kRequestsPerConnection);
        set_keep_alive_timeout(kKeepAliveSeconds);
        set_write_timeout(kWriteSeconds);
        set_pre_routing_handler([this](const httplib::Request&, httplib::Response& response) {
            answer(response);
            return HandlerResponse::Handled;
        });
        set_post_routing_handler(
            [](const httplib::Request&, httplib::Response& response) { correct_headers(response); });
        // Its default tells the client what was thrown.
        set_exception_handler([](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
            answering->last = true;
            response.status = 500;
        });
    }

    Result<int> bind(const std::string& address, int port) {
        errno = 0;
        const int bound = port == 0 ? bind_to_any_port(address) : (bind_to_port(address, port) ? port : -1);
        if (bound < 0 || ::listen(svr_sock_, kBacklog) != 0) {
            const std::string reason = errno == 0 ? "the address is unknown" : std::strerror(errno);
            return failure(ErrorCode::Unusable,
                           "cannot listen on " + address + " port " + std::to_string(port) + ": " + reason);
        }
        return bound;
    }

    bool serve() { return listen_after_bind() || draining_; }

    void drain() {
        draining_ = true;
        // Makes accept fail, now and later; `stop` would do nothing before the server runs.
        ::shutdown(svr_sock_, SHUT_RDWR);
    }

private:
    bool process_and_close_socket(socket_t socket) override {
        Connection connection(socket);
        try {
            serve_connection(connection);
        } catch (...) {
            // Out of memory for the answer, most likely. The other connections go on.
        }
        connection.close_gently();
        ::close(socket);
        return true;
    }

    void serve_connection(Connection& connection) {
        const auto give_up = [this](milliseconds waited) {
            const bool pressed = waiting_ > 0 || (draining_ && busy_ == 0);
            return waited >= (pressed ? kIdleUnderPressure : milliseconds(std::chrono::seconds(kKeepAliveSeconds)));
        };
        for (std::size_t left = keep_alive_max_count_; left > 0 && connection.wait_for_request(give_up); --left) {
            const Counted busy(busy_);
            if (!serve_request(connection, left == 1)) break;
        }
    }

    /// @returns  whether another request may follow
    bool serve_request(Connection& connection, bool last) {
        const auto start = Clock::now();
        Answering current{connection, {}, {}, {}, last};
        if (auto request = connection.read_head())
            current.request = std::move(*request);
        else
            current.fault = request.error();

        AnswerStream stream(current);
        bool closed = false;
        answering = &current;
        const bool written = process_request(stream, false, closed, nullptr);
        answering = nullptr;
        const std::chrono::duration<double, std::milli> elapsed = Clock::now() - start;
        logger_({std::move(current.request), std::move(current.response), connection.client(), connection.bytes_in(),
                 connection.bytes_out(), elapsed.count()});
        return written && !current.last;
    }

    void answer(httplib::Response& response) {
        Response& ours = answering->response = handler_(answering->request, answering->fault, answering->connection);
        answering->last = answering->last || draining_ || !ours.deliver || !answering->request.keep_alive ||
                          !answering->connection.between_requests();
        response.status = ours.status;
        for (const auto& [name, value] : ours.headers) response.set_header(name, value);
        if (!ours.media_type.empty()) response.set_header("Content-Type", ours.media_type);
        response.body = std::move(ours.body);
    }

    /// cpp-httplib decides on some headers by the request it saw, which is not the client's.
    static void correct_headers(httplib::Response& response) {
        erase_header(response, "Accept-Ranges");
        if (response.status == 204) erase_header(response, "Content-Length");
        if (!answering->last) return;
        erase_header(response, "Keep-Alive");
        response.set_header("Connection", "close");
    }

    const HttpServer::Handler handler_;
    const HttpServer::Logger logger_;
    std::atomic<bool> draining_ = false;
    std::atomic<int> waiting_ = 0;  ///< connections without a thread
    std::atomic<int> busy_ = 0;     ///< connections with a request
};

HttpServer::HttpServer(std::size_t threads, Handler handler, Logger logger)
    : listener_(std::make_unique<Listener>(threads, std::move(handler), std::move(logger))) {}

HttpServer::~HttpServer() = default;

Result<int> HttpServer::bind(const std::string& address, int port) {
    return listener_->bind(address, port);
}

bool HttpServer::serve() {
    return listener_->serve();
}

void HttpServer::drain() {
    listener_->drain();
}

}  // namespace ccdt::server
