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

#include "core/result.h"
#include "server/redis/redis_address.h"
#include "server/redis/redis_connection.h"
#include "server/redis/redis_script.h"

namespace ccdt::server {

/// Runs commands on a Redis server. Thread-safe; each call uses a connection of its own.
///
/// A lost connection is replaced. If the connection had been idle before the call, the commands of the call are sent
/// once more, so they should be idempotent. While Redis cannot be reached or does not reply in time, calls fail at
/// once. After each pause of up to a second, one call tries again. If Redis reports that it is a replica, all
/// connections are replaced, because the address may lead to another server by then.
/// Errors of all calls: Stopped if Redis cannot be reached within the deadline; LimitExceeded if its memory is full;
/// Unusable if a key has a value of another type; Internal for all other errors.
class RedisClient {
public:
    using Clock = std::chrono::steady_clock;

    struct Counts {
        std::uint64_t calls = 0;
        std::uint64_t failures = 0;  ///< calls that failed
        std::uint64_t damages = 0;   ///< keys that were reported as damaged
        double seconds = 0;          ///< total duration of all calls, in seconds
    };

    /// Writes a message to the log.
    using Warn = std::function<void(const std::string&)>;

    /// @param deadline  time limit of each call
    /// @param warn      receives reports of damaged keys, from any thread; may be empty
    explicit RedisClient(RedisAddress address, std::chrono::milliseconds deadline = kDeadline, Warn warn = {});

    /// @returns  one reply for each command; none of the replies is an error
    Result<std::vector<RedisReply>> run(std::span<const RedisCommand> commands);
    Result<RedisReply> run(RedisCommand command);

    /// Runs a script, which is sent only if Redis does not know it.
    /// @param key  key on which the script works
    Result<RedisReply> run(const RedisScript& script, std::string_view key, const RedisCommand& arguments);

    /// Logs and counts a key whose value is not what was written.
    /// @param remedy  consequence or repair of the damage, for the log
    void report_damage(std::string_view key, std::string_view remedy);

    /// Returns a setting of Redis; empty if Redis does not reveal it.
    std::string setting(std::string_view name);

    Counts counts() const;
    const RedisAddress& address() const { return address_; }

    static constexpr std::chrono::milliseconds kDeadline{2'000};

private:
    using Connection = std::unique_ptr<RedisConnection>;

    /// Counts one connection in use.
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
    Clock::time_point retry_;  ///< no attempt to connect before this time
    std::chrono::milliseconds pause_{0};
    Error away_;  ///< the error of the latest failed attempt to reach Redis
    Counts counts_;
};

}  // namespace ccdt::server
