// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/redis/redis_client.h"

#include <algorithm>
#include <utility>

namespace ccdt::server {
namespace {

/// Maximum number of connections. More would not help, because Redis runs one command at a time.
constexpr std::size_t kMaxConnections = 16;

constexpr std::chrono::milliseconds kMinPause{50};
constexpr std::chrono::milliseconds kMaxPause{1'000};

/// Error codes of a Redis that cannot run commands now, but may recover or be replaced by another server.
constexpr std::string_view kNotNow[] = {"LOADING", "READONLY", "BUSY", "MASTERDOWN", "CLUSTERDOWN", "UNKILLABLE"};

Error error_of(const RedisReply& reply, const RedisAddress& address) {
    const std::string message = "Redis at " + address.name() + ": " + reply.text;
    if (reply.is_error("OOM")) return {ErrorCode::LimitExceeded, message, {}};
    if (reply.is_error("MOVED")) return {ErrorCode::Internal, message + " (Redis Cluster is not supported)", {}};
    if (reply.is_error("WRONGTYPE")) return {ErrorCode::Unusable, message, {}};
    for (const auto code : kNotNow)
        if (reply.is_error(code)) return {ErrorCode::Stopped, message, {}};
    return {ErrorCode::Internal, message, {}};
}

}  // namespace

class RedisClient::Permit {
public:
    Permit(RedisClient& client, Clock::time_point deadline) : client_(client) {
        std::unique_lock lock(client_.mutex_);
        has_ = client_.free_.wait_until(lock, deadline, [&] { return client_.in_use_ < kMaxConnections; });
        if (has_) ++client_.in_use_;
    }
    ~Permit() {
        if (!has_) return;
        const std::lock_guard lock(client_.mutex_);
        --client_.in_use_;
        client_.free_.notify_one();
    }
    Permit(const Permit&) = delete;
    Permit& operator=(const Permit&) = delete;

    explicit operator bool() const { return has_; }

private:
    RedisClient& client_;
    bool has_ = false;
};

RedisClient::RedisClient(RedisAddress address, std::chrono::milliseconds deadline, Warn warn)
    : address_(std::move(address)), deadline_(deadline), warn_(std::move(warn)) {}

Result<std::vector<RedisReply>> RedisClient::run(std::span<const RedisCommand> commands) {
    const auto began = Clock::now();
    auto replies = attempt(commands, began + deadline_);
    if (replies) {
        const auto failed = std::ranges::find(*replies, RedisReply::Kind::Error, &RedisReply::kind);
        if (failed != replies->end() && failed->is_error("READONLY")) drop_idle();
        if (failed != replies->end() && !failed->is_error("NOSCRIPT"))
            replies = tl::unexpected(error_of(*failed, address_));
    }
    const std::lock_guard lock(mutex_);
    ++counts_.calls;
    if (!replies) ++counts_.failures;
    counts_.seconds += std::chrono::duration<double>(Clock::now() - began).count();
    return replies;
}

Result<RedisReply> RedisClient::run(RedisCommand command) {
    auto replies = run(std::span(&command, 1));
    if (!replies) return tl::unexpected(std::move(replies.error()));
    return std::move(replies->front());
}

Result<RedisReply> RedisClient::run(const RedisScript& script, std::string_view key, const RedisCommand& arguments) {
    RedisCommand command{"EVALSHA", script.digest(), "1", key};
    command.insert(command.end(), arguments.begin(), arguments.end());
    auto reply = run(command);
    if (!reply || !reply->is_error("NOSCRIPT")) return reply;
    command[0] = "EVAL";
    command[1] = script.source();
    return run(std::move(command));
}

void RedisClient::report_damage(std::string_view key, std::string_view remedy) {
    {
        const std::lock_guard lock(mutex_);
        ++counts_.damages;
    }
    if (warn_)
        warn_(std::string("the key ").append(key).append(" of Redis at ").append(address_.name()) +
              " was damaged: " + std::string(remedy));
}

std::string RedisClient::setting(std::string_view name) {
    const auto reply = run(RedisCommand{"CONFIG", "GET", name});
    return reply && reply->items.size() == 2 ? reply->items[1].text : "";
}

Result<std::vector<RedisReply>> RedisClient::attempt(std::span<const RedisCommand> commands,
                                                     Clock::time_point deadline) {
    const Permit permit(*this, deadline);
    if (!permit) return failure(ErrorCode::Stopped, "Redis at " + address_.name() + ": too many calls at once");
    if (auto connection = take_idle()) {
        auto replies = connection->run(commands, deadline);
        if (replies) put_back(std::move(connection));
        if (replies) return replies;
        drop_idle();  // other idle connections are probably lost, too
        if (Clock::now() >= deadline) return late(replies.error());
    }
    auto connection = connect(deadline);
    if (!connection) return tl::unexpected(std::move(connection.error()));
    auto replies = (*connection)->run(commands, deadline);
    if (!replies) return late(replies.error());
    put_back(*std::move(connection));
    return replies;
}

/// Returns the error of a call that could not reach Redis. Starts a pause during which no call connects to Redis.
tl::unexpected<Error> RedisClient::late(const Error& error) {
    const std::lock_guard lock(mutex_);
    pause_locked(error);
    return tl::unexpected(error);
}

void RedisClient::pause_locked(const Error& error) {
    pause_ = std::clamp(2 * pause_, kMinPause, kMaxPause);
    retry_ = Clock::now() + pause_;
    away_ = error;
}

RedisClient::Connection RedisClient::take_idle() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return nullptr;
    Connection connection = std::move(idle_.back());
    idle_.pop_back();
    return connection;
}

/// Opens a connection. Fails at once during the pause after a failure.
Result<RedisClient::Connection> RedisClient::connect(Clock::time_point deadline) {
    {
        const std::lock_guard lock(mutex_);
        if (Clock::now() < retry_) return tl::unexpected(away_);
        if (pause_.count() > 0) retry_ = Clock::now() + deadline_;  // other calls do not connect meanwhile
    }
    auto connection = RedisConnection::open(address_, deadline);
    const std::lock_guard lock(mutex_);
    if (connection) {
        pause_ = {};
        retry_ = {};
    } else {
        pause_locked(connection.error());
    }
    return connection;
}

void RedisClient::put_back(Connection connection) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(connection));
}

void RedisClient::drop_idle() {
    std::vector<Connection> dropped;
    const std::lock_guard lock(mutex_);
    dropped.swap(idle_);
}

RedisClient::Counts RedisClient::counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
}

}  // namespace ccdt::server
