// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include "core/base/result.h"
#include "server/redis/redis_address.h"
#include "server/redis/redis_connection.h"

namespace ccdt::server {

/// Subscribes to a channel of a Redis server, with a separate thread and connection. Reconnects after each loss of the
/// connection, with pauses of up to a second.
class RedisSubscription {
public:
    using Clock = std::chrono::steady_clock;

    /// Functions that the thread of the subscription calls.
    struct Callbacks {
        std::function<void(std::string_view)> message;
        std::function<void()> begun;              ///< the subscription exists; messages from now on are delivered
        std::function<void(const Error&)> ended;  ///< messages may be lost; called once per outage
    };

    RedisSubscription(RedisAddress address, std::string channel, Callbacks callbacks);

    RedisSubscription(const RedisSubscription&) = delete;
    RedisSubscription& operator=(const RedisSubscription&) = delete;

private:
    void listen(const std::stop_token& closing);
    Error listen_once(const std::stop_token& closing);
    static Error deliver(RedisConnection& connection, const Callbacks& callbacks, const std::stop_token& closing);

    const RedisAddress address_;
    const std::string channel_;
    const Callbacks callbacks_;
    bool begun_ = false;   ///< used only by `thread_`
    std::jthread thread_;  ///< last, because it uses all other members
};

}  // namespace ccdt::server
