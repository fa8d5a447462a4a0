// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/fetch/fetch.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <future>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "api/text/text.h"
#include "server/fetch/fetch_protocol.h"
#include "server/http/http_client.h"
#include "server/http/sockets.h"
#include "server/processes/child_program.h"
#include "server/processes/messages.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;

/// Interval at which `given_up` is called.
constexpr std::chrono::milliseconds kPollInterval{20};

constexpr std::size_t kMaxMessage = 200;

tl::unexpected<Problem> not_fetched(const std::string& why) {
    return problem(422, "image_url: " + why);
}

tl::unexpected<Problem> too_large() {
    return problem(413, "image_url: the file is too large (max-body)");
}

/// Waits for an event; returns a problem after the deadline or if the file is no longer wanted.
/// @param happens_until  waits for the event until a time, and returns whether it has happened
template <class HappensUntil>
HttpResult<void> wait_for(const HappensUntil& happens_until, Clock::time_point deadline,
                          const std::function<bool()>& given_up) {
    while (!given_up()) {
        if (Clock::now() >= deadline) return not_fetched("the host took too long");
        if (happens_until(std::min(deadline, Clock::now() + kPollInterval))) return {};
    }
    return not_fetched("the file is no longer wanted");
}

HttpResult<void> wait_for_event(int descriptor, short event, Clock::time_point deadline,
                                const std::function<bool()>& given_up) {
    const auto happens_until = [&](Clock::time_point time) {
        pollfd polled{descriptor, event, 0};
        return poll(&polled, 1, milliseconds_until(time)) > 0;
    };
    return wait_for(happens_until, deadline, given_up);
}

/// The outcome of a look-up: an error of getaddrinfo(), or addresses.
struct Lookup {
    int error = 0;
    std::shared_ptr<const addrinfo> found;
};

/// Looks up a host in a thread of its own, which keeps `slot`.
HttpResult<Lookup> look_up(const Origin& origin, Clock::time_point deadline, const std::function<bool()>& given_up,
                           const std::shared_ptr<void>& slot, const Resolver& resolve) {
    std::packaged_task<Lookup()> task([host = origin.host, port = origin.port, slot, resolve] {
        addrinfo wanted{};
        wanted.ai_socktype = SOCK_STREAM;
        wanted.ai_flags = AI_NUMERICSERV;
        addrinfo* found = nullptr;
        const int error = resolve(host.c_str(), port.c_str(), &wanted, &found);
        if (error != 0) return Lookup{error, nullptr};
        return Lookup{0, {found, [](addrinfo* list) { freeaddrinfo(list); }}};
    });
    std::future<Lookup> lookup = task.get_future();
    try {
        std::thread(std::move(task)).detach();
    } catch (const std::system_error&) {
        return problem(503, "there are too few threads left");
    }
    const auto happens_until = [&](Clock::time_point time) {
        return lookup.wait_until(time) == std::future_status::ready;
    };
    return wait_for(happens_until, deadline, given_up).map([&] { return lookup.get(); });
}

/// Connects to the first permitted address of a host that accepts the connection.
HttpResult<UniqueFd> connect_to_origin(const Origin& origin, const Lookup& lookup, const TargetHosts& origins,
                                       Clock::time_point deadline, const std::function<bool()>& given_up) {
    if (lookup.error != 0)
        return not_fetched("the host " + origin.host + " was not found: " + gai_strerror(lookup.error));
    std::string failure;
    for (const addrinfo* each = lookup.found.get(); each != nullptr; each = each->ai_next) {
        sockaddr_storage address{};
        std::memcpy(&address, each->ai_addr, std::min<std::size_t>(each->ai_addrlen, sizeof(address)));
        const Peer peer = describe_peer(address);
        if (!peer.ip || !origins.permits(*peer.ip)) {
            failure = "its address is not public and not permitted";
            continue;
        }
        UniqueFd connection(socket(each->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
        if (!connection) return problem(503, "there are too few descriptors left");
        if (connect(connection.get(), each->ai_addr, each->ai_addrlen) != 0 && errno == EINPROGRESS) {
            if (auto ready = wait_for_event(connection.get(), POLLOUT, deadline, given_up); !ready)
                return tl::unexpected(std::move(ready.error()));
        }
        int error = 0;
        socklen_t size = sizeof(error);
        sockaddr_storage other{};
        socklen_t length = sizeof(other);
        getsockopt(connection.get(), SOL_SOCKET, SO_ERROR, &error, &size);
        if (error == 0 && getpeername(connection.get(), reinterpret_cast<sockaddr*>(&other), &length) == 0)
            return connection;
        failure = std::strerror(error != 0 ? error : errno);
    }
    return not_fetched("the host " + origin.host + " cannot be reached: " + failure);
}

/// The outcome of an exchange: the file, or the URL of a redirect.
struct Fetched {
    std::string file;
    std::string redirect;
};

/// Receives what a fetcher reports.
HttpResult<Fetched> receive(int fetcher, const FetchLimits& limits, Clock::time_point deadline,
                            const std::function<HttpResult<void>(std::size_t)>& reserve,
                            const std::function<bool()>& given_up) {
    Fetched fetched;
    bool reserved = false;
    std::array<char, kMaxFetchNews> message{};
    while (true) {
        if (auto ready = wait_for_event(fetcher, POLLIN, deadline, given_up); !ready)
            return tl::unexpected(std::move(ready.error()));
        const std::size_t size = receive_message(fetcher, std::as_writable_bytes(std::span(message)));
        if (size == 0) return not_fetched("the answer of the host cannot be read");
        const std::string_view text(message.data() + 1, size - 1);
        switch (static_cast<FetchNews>(message[0])) {
            case FetchNews::Size: {
                const auto bytes = api::parse_number<std::size_t>(text).value_or(limits.max_bytes);
                if (bytes > limits.max_bytes || std::exchange(reserved, true)) return too_large();
                if (auto done = reserve(bytes); !done) return tl::unexpected(std::move(done.error()));
                break;
            }
            case FetchNews::Piece:
                if (!reserved || text.size() > limits.max_bytes - fetched.file.size()) return too_large();
                fetched.file += text;
                break;
            case FetchNews::Done:
                return fetched;
            case FetchNews::Redirect:
                fetched.redirect = text;
                return fetched;
            case FetchNews::TooLarge:
                return too_large();
            case FetchNews::Failed:
            default:
                return not_fetched(std::string(text.substr(0, kMaxMessage)));
        }
    }
}

}  // namespace

HttpResult<std::string> fetch(std::string url, const TargetHosts& origins, const FetchLimits& limits,
                              const std::function<HttpResult<void>(std::size_t)>& reserve,
                              const std::function<bool()>& given_up, const std::shared_ptr<void>& slot,
                              const Resolver& resolve) {
    const auto deadline = Clock::now() + limits.timeout;
    for (int redirects = 0; redirects <= limits.max_redirects; ++redirects) {
        const auto origin = check_target(url, origins);
        if (!origin) return problem(400, "image_url: " + origin.error().message + " (origin)");
        const auto lookup = look_up(*origin, deadline, given_up, slot, resolve);
        if (!lookup) return tl::unexpected(lookup.error());
        auto connection = connect_to_origin(*origin, *lookup, origins, deadline, given_up);
        if (!connection) return tl::unexpected(std::move(connection.error()));
        auto sockets = make_sockets(SOCK_SEQPACKET);
        if (!sockets) return problem(503, "there are too few descriptors left");
        auto program = spawn_sibling("ccdt-fetcher", std::move(sockets->theirs));
        if (!program) return problem(500, program.error().message);
        FetchOrder order{.max_bytes = limits.max_bytes, .timeout_ms = limits.timeout.count()};
        url.copy(order.url.data(), FetchOrder::kMaxUrl);
        const int passed = connection->get();
        if (!send_message(sockets->ours.get(), bytes_of(order), std::span(&passed, 1)))
            return not_fetched("the answer of the host cannot be read");
        connection->reset();
        auto fetched = receive(sockets->ours.get(), limits, deadline, reserve, given_up);
        if (!fetched) return tl::unexpected(std::move(fetched.error()));
        if (fetched->redirect.empty()) return std::move(fetched->file);
        url = std::move(fetched->redirect);
    }
    return not_fetched("there are too many redirects");
}

}  // namespace ccdt::server
