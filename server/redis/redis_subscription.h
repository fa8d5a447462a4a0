#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include "core/result.h"
#include "server/redis/redis_address.h"
#include "server/redis/redis_connection.h"

namespace ccdt::server {

/// Listens to what is published in a channel of a Redis, by a thread and a connection of its own. Connects again
/// whenever the connection is lost, with pauses of up to a second.
class RedisSubscription {
public:
    using Clock = std::chrono::steady_clock;

    /// What is told, by the subscription's thread.
    struct Told {
        std::function<void(std::string_view)> message;
        std::function<void()> begun;              ///< all that is published from now on is told
        std::function<void(const Error&)> ended;  ///< what is published may be missed; once until it is begun again
    };

    RedisSubscription(RedisAddress address, std::string channel, Told told);

    RedisSubscription(const RedisSubscription&) = delete;
    RedisSubscription& operator=(const RedisSubscription&) = delete;

private:
    void listen(const std::stop_token& closing);
    Error listen_once(const std::stop_token& closing);
    static Error hear(RedisConnection& connection, const Told& told, const std::stop_token& closing);

    const RedisAddress address_;
    const std::string channel_;
    const Told told_;
    bool begun_ = false;   ///< of the thread
    std::jthread thread_;  ///< last: it uses all the rest
};

}  // namespace ccdt::server
