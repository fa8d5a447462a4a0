// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "server/redis/redis_address.h"
#include "server/redis/redis_connection.h"
#include "server/redis/redis_script.h"

namespace ccdt::server {

/// Runs commands on a Redis server. Thread-safe. Simultaneous calls use different connections.
///
/// If an idle connection turns out to be lost, the call opens a new connection and sends its commands again. Commands
/// should therefore be idempotent. After a failure to reach Redis, calls fail at once during a pause of up to a second;
/// then one call tries again. If Redis reports that it is a replica, all connections are replaced, because the address
/// may now lead to another server.
/// Errors of all calls: Stopped if Redis cannot be reached within the deadline; LimitExceeded if its memory is full;
/// Unusable if a key has a value of another type; Internal for all other errors.
class RedisClient {
public:
    using Clock = std::chrono::steady_clock;

    struct Counts {
        std::uint64_t calls = 0;
        std::uint64_t failures = 0;  ///< calls that failed
        std::uint64_t damages = 0;   ///< calls of report_damage()
        double seconds = 0;          ///< total duration of all calls, in seconds
    };

    /// Writes a message to the log.
    using Warn = std::function<void(const std::string&)>;

    /// @param deadline  maximum duration of each call
    /// @param warn      receives reports of damaged keys, from any thread; may be empty
    explicit RedisClient(RedisAddress address, std::chrono::milliseconds deadline = kDeadline, Warn warn = {});

    /// Runs commands. Returns one reply for each command; error replies become errors of the call.
    Result<std::vector<RedisReply>> run(std::span<const RedisCommand> commands);
    Result<RedisReply> run(RedisCommand command);

    /// Runs a script. Sends its source only if Redis does not know it.
    /// @param key  key that the script receives as KEYS[1]
    Result<RedisReply> run(const RedisScript& script, std::string_view key, const RedisCommand& arguments);

    /// Logs and counts a key whose value another program has damaged.
    /// @param remedy  consequence or repair of the damage, for the message
    void report_damage(std::string_view key, std::string_view remedy);

    /// Returns a setting of Redis; empty if Redis does not permit reading it.
    std::string setting(std::string_view name);

    Counts counts() const;
    const RedisAddress& address() const { return address_; }

    static constexpr std::chrono::milliseconds kDeadline{2'000};

private:
    using Connection = std::unique_ptr<RedisConnection>;

    /// Counts a connection in use during the lifetime of this object.
    class Permit;

    Result<std::vector<RedisReply>> attempt(std::span<const RedisCommand> commands, Clock::time_point deadline);
    tl::unexpected<Error> late(const Error& error);
    void pause_locked(const Error& error);
    Connection take_idle();
    Result<Connection> connect(Clock::time_point deadline);
    void put_back(Connection connection);
    void drop_idle();

    const RedisAddress address_;
    const std::chrono::milliseconds deadline_;
    const Warn warn_;

    mutable std::mutex mutex_;  ///< guards the members below
    std::condition_variable free_;
    std::size_t in_use_ = 0;
    std::vector<Connection> idle_;
    Clock::time_point retry_;  ///< calls fail without connecting until this time
    std::chrono::milliseconds pause_{0};
    Error away_;  ///< error of the latest failed attempt to reach Redis
    Counts counts_;
};

}  // namespace ccdt::server
