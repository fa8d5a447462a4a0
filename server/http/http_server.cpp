#include "server/http/http_server.h"

#include <httplib.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <deque>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/connection_threads.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kRequestsPerConnection = 10'000;

/// A connection without a request makes room after this long if there is little room left or the server drains.
constexpr milliseconds kIdleUnderPressure{500};

/// How long a refused client has to read why, and how many of them at once.
constexpr milliseconds kParting{500};
constexpr std::size_t kMostParting = 256;

/// Status in the log of an answer that its client did not take.
constexpr int kClientLeft = 499;

/// After accepting failed for want of files or memory.
constexpr milliseconds kRecovery{10};

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

/// Sockets of refused clients. They are closed a little later, since closing with unread bytes resets the connection,
/// and the client might lose the answer. Nothing is read from them.
class Parting {
public:
    bool empty() const { return sockets_.empty(); }

    void add(UniqueFd socket) {
        sockets_.push_back({std::move(socket), Clock::now()});
        if (sockets_.size() > kMostParting) sockets_.pop_front();
    }

    void close_old() {
        while (!sockets_.empty() && Clock::now() >= sockets_.front().since + kParting) sockets_.pop_front();
    }

private:
    struct Entry {
        UniqueFd socket;
        Clock::time_point since;
    };

    std::deque<Entry> sockets_;
};

/// Does what may fail for one client only: out of memory, most likely, and the other clients go on.
template <class Task>
void contain(const Task& task) {
    try {
        task();
    } catch (...) {
        // There is nobody to tell: the client's connection is closed, and what failed may have been the log.
    }
}

Fault refusal(Place::Entry entry) {
    const std::string reason = entry == Place::Entry::AddressFull
                                   ? "this address has too many connections (max-connections-per-address)"
                                   : "too many connections are open (max-connections)";
    return {503, reason, {{"Retry-After", "1"}}};
}

/// Sends a body that comes about while it is sent, in chunks if the client knows them; else the end of the connection
/// is its end.
/// @returns  false if the client did not take all of it
bool stream_body(Answering& current) {
    Connection& connection = current.connection;
    const bool chunked = !current.request.is_http_1_0;
    bool taken = true;
    current.response.stream([&](std::string_view piece) {
        if (!taken || piece.empty()) return taken;  // an empty chunk is the last one
        char size[20];
        std::snprintf(size, sizeof(size), "%zx\r\n", piece.size());
        taken = connection.write(chunked ? size + std::string(piece) + "\r\n" : std::string(piece));
        return taken;
    });
    return taken && !connection.client_gone() && (!chunked || connection.write("0\r\n\r\n"));
}

bool is_fatal(int accept_error) {
    return accept_error == EBADF || accept_error == EINVAL || accept_error == ENOTSOCK || accept_error == EOPNOTSUPP;
}

}  // namespace

class HttpServer::Reception : public httplib::Server {
public:
    Reception(const Patience& patience, const Capacity::Limits& limits, HttpServer::Handler handler,
              HttpServer::Logger logger)
        : patience_(patience), capacity_(limits), handler_(std::move(handler)), logger_(std::move(logger)) {
        set_keep_alive_max_count(kRequestsPerConnection);
        set_keep_alive_timeout(std::chrono::ceil<std::chrono::seconds>(patience.idle).count());
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
        auto opened = ListeningSocket::open(address, port);
        if (!opened) return tl::unexpected(std::move(opened.error()));
        listener_.emplace(std::move(*opened));
        return listener_->port();
    }

    bool serve() {
        ConnectionThreads threads(patience_.idle);
        Parting parting;
        while (!draining_) {
            wait_for_client(parting);
            sockaddr_storage address{};
            socklen_t size = sizeof(address);
            UniqueFd socket(
                accept4(listener_->descriptor(), reinterpret_cast<sockaddr*>(&address), &size, SOCK_CLOEXEC));
            if (socket)
                contain([&] { receive(std::move(socket), describe_peer(address), threads, parting); });
            else if (is_fatal(errno))
                return draining_;
            else if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED)
                poll(nullptr, 0, kRecovery.count());
        }
        return true;
    }

    void drain() {
        draining_ = true;
        capacity_.close();
        // Makes accept fail, now and later.
        ::shutdown(listener_->descriptor(), SHUT_RDWR);
    }

    Capacity::Counts connections() const { return capacity_.counts(); }

private:
    void wait_for_client(Parting& parting) const {
        pollfd entry{listener_->descriptor(), POLLIN, 0};
        poll(&entry, 1, parting.empty() ? -1 : static_cast<int>(kParting.count()));
        parting.close_old();
    }

    /// Gives a new connection its thread, or tells it that there is none.
    void receive(UniqueFd socket, const Peer& peer, ConnectionThreads& threads, Parting& parting) {
        const int yes = 1;
        setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
        const auto place = std::make_shared<Place>(capacity_, peer.address);
        auto entry = place->entry();
        if (entry == Place::Entry::Admitted) {
            if (threads.run([this, socket = socket.get(), place] { serve_socket(UniqueFd(socket), *place); })) {
                socket.release();
                return;
            }
            entry = Place::Entry::Full;
        }
        contain([&] {
            Connection connection(socket.get(), patience_, &capacity_);
            answer_request(connection, {}, refusal(entry), true);
        });
        ::shutdown(socket.get(), SHUT_WR);
        parting.add(std::move(socket));
    }

    void serve_socket(const UniqueFd& socket, Place& place) {
        contain([&] {
            Connection connection(socket.get(), patience_, &capacity_, &place);
            contain([&] { serve_connection(connection, place); });
            connection.close_gently();
        });
    }

    void serve_connection(Connection& connection, const Place& place) {
        // Whoever connects has something to ask.
        auto longest = patience_.header;
        const auto give_up = [&](milliseconds waited) {
            const bool idles_elsewhere = place.room() != Room::Common;
            const bool pressed = capacity_.is_pressed() || idles_elsewhere || (draining_ && busy_ == 0);
            return waited >= (pressed ? std::min(longest, kIdleUnderPressure) : longest);
        };
        for (std::size_t left = keep_alive_max_count_; left > 0 && connection.wait_for_request(give_up); --left) {
            const Counted busy(busy_);
            auto request = connection.read_head();
            const auto fault = request ? find_fault(*request) : request.error();
            if (!answer_request(connection, request ? std::move(*request) : Request(), fault, fault || left == 1))
                break;
            longest = patience_.idle;
        }
    }

    /// @returns  whether another request may follow
    bool answer_request(Connection& connection, Request request, std::optional<Fault> fault, bool last) {
        const auto start = Clock::now();
        Answering current{connection, std::move(request), std::move(fault), {}, last};
        AnswerStream stream(current);
        bool closed = false;
        answering = &current;
        bool written = process_request(stream, false, closed, nullptr);
        answering = nullptr;
        if (written && current.response.stream && current.request.method != "HEAD") written = stream_body(current);
        if (!written) current.response.status = kClientLeft;
        const std::chrono::duration<double, std::milli> elapsed = Clock::now() - start;
        logger_({std::move(current.request), std::move(current.response), connection.client(), connection.bytes_in(),
                 connection.bytes_out(), elapsed.count()});
        return written && !current.last;
    }

    void answer(httplib::Response& response) {
        Response& ours = answering->response = handler_(answering->request, answering->fault, answering->connection);
        answering->last = answering->last || draining_ || !ours.deliver || !answering->request.keep_alive ||
                          answering->connection.in_reserve() || !answering->connection.between_requests() ||
                          (ours.stream && answering->request.is_http_1_0);
        response.status = ours.status;
        for (const auto& [name, value] : ours.headers) response.set_header(name, value);
        if (!ours.media_type.empty()) response.set_header("Content-Type", ours.media_type);
        response.body = std::move(ours.body);
    }

    /// cpp-httplib decides on some headers by the request it saw, which is not the client's.
    static void correct_headers(httplib::Response& response) {
        erase_header(response, "Accept-Ranges");
        const bool streams = static_cast<bool>(answering->response.stream);
        if (response.status == 204 || response.status == 304 || streams) erase_header(response, "Content-Length");
        if (streams && !answering->request.is_http_1_0) response.set_header("Transfer-Encoding", "chunked");
        if (answering->last) erase_header(response, "Keep-Alive");
        if (answering->last) response.set_header("Connection", "close");
        if (!answering->last && answering->request.is_http_1_0) response.set_header("Connection", "keep-alive");
    }

    const Patience patience_;
    Capacity capacity_;
    std::optional<ListeningSocket> listener_;
    const HttpServer::Handler handler_;
    const HttpServer::Logger logger_;
    std::atomic<bool> draining_ = false;
    std::atomic<int> busy_ = 0;  ///< connections with a request
};

HttpServer::HttpServer(const Patience& patience, const Capacity::Limits& limits, Handler handler, Logger logger)
    : reception_(std::make_unique<Reception>(patience, limits, std::move(handler), std::move(logger))) {}

HttpServer::~HttpServer() = default;

Result<int> HttpServer::bind(const std::string& address, int port) {
    return reception_->bind(address, port);
}

bool HttpServer::serve() {
    return reception_->serve();
}

void HttpServer::drain() {
    reception_->drain();
}

Capacity::Counts HttpServer::connections() const {
    return reception_->connections();
}

}  // namespace ccdt::server
