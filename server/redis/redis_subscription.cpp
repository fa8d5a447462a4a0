// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/redis/redis_subscription.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace ccdt::server {
namespace {

constexpr std::chrono::milliseconds kDeadline{2'000};
constexpr std::chrono::milliseconds kMinPause{50};
constexpr std::chrono::milliseconds kMaxPause{1'000};

/// Interval at which the thread checks for a stop request.
constexpr std::chrono::milliseconds kPollInterval{100};

/// Time without a message after which the thread sends a PING to Redis.
constexpr std::chrono::milliseconds kSilence{1'000};

}  // namespace

RedisSubscription::RedisSubscription(RedisAddress address, std::string channel, Callbacks callbacks)
    : address_(std::move(address)),
      channel_(std::move(channel)),
      callbacks_(std::move(callbacks)),
      thread_([this](const std::stop_token& closing) { listen(closing); }) {}

void RedisSubscription::listen(const std::stop_token& closing) {
    auto pause = kMinPause;
    bool ended = false;  // `callbacks_.ended` was called
    while (!closing.stop_requested()) {
        const Error error = listen_once(closing);
        if (std::exchange(begun_, false)) {
            ended = false;
            pause = kMinPause;
        }
        if (closing.stop_requested()) return;
        if (!std::exchange(ended, true)) callbacks_.ended(error);
        std::mutex mutex;
        std::unique_lock lock(mutex);
        std::condition_variable_any().wait_for(lock, closing, pause, [] { return false; });
        pause = std::min(2 * pause, kMaxPause);
    }
}

/// Subscribes, and delivers messages until the subscription ends. Returns the reason for its end.
Error RedisSubscription::listen_once(const std::stop_token& closing) {
    auto connection = RedisConnection::open(address_, Clock::now() + kDeadline);
    if (!connection) return connection.error();
    const RedisCommand subscribe{"SUBSCRIBE", channel_};
    const auto subscribed = (*connection)->run(std::span(&subscribe, 1), Clock::now() + kDeadline);
    if (!subscribed) return subscribed.error();
    if (subscribed->front().kind == RedisReply::Kind::Error)
        return {ErrorCode::Stopped, "Redis at " + address_.name() + ": " + subscribed->front().text, {}};
    begun_ = true;
    callbacks_.begun();
    return deliver(**connection, callbacks_, closing);
}

/// Delivers messages until the connection is lost. Returns the reason.
Error RedisSubscription::deliver(RedisConnection& connection, const Callbacks& callbacks,
                                 const std::stop_token& closing) {
    auto last_message = Clock::now();
    bool pinged = false;
    while (!closing.stop_requested()) {
        const auto reply = connection.receive(Clock::now() + kPollInterval);
        if (!reply) return reply.error();
        if (*reply) {
            last_message = Clock::now();
            pinged = false;
            const auto& items = (*reply)->items;
            if (items.size() == 3 && items[0].text == "message") callbacks.message(items[2].text);
        } else if (pinged && Clock::now() - last_message > kSilence + kDeadline) {
            return {ErrorCode::Stopped, "Redis does not reply", {}};
        } else if (!pinged && Clock::now() - last_message > kSilence) {
            pinged = true;
            if (const auto sent = connection.send({"PING"}, Clock::now() + kDeadline); !sent) return sent.error();
        }
    }
    return {};
}

}  // namespace ccdt::server
