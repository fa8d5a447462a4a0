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

/// Has a Redis do things. May be used from any thread; each call has a connection for itself.
///
/// A connection that was lost is made again: what was on its way is sent once more if the connection had been idle, so
/// that commands should do no harm if they are done twice. While Redis cannot be reached calls fail at once, but for
/// one after each pause, of up to a second; also once it does not answer in time. All connections are made again once
/// it says that it is a copy: its address may be another one's by then. Errors of all: Stopped if it cannot be reached,
/// or not within the deadline; LimitExceeded if its memory is full; Unusable if a key holds a value of another type;
/// Internal for whatever else it says.
class RedisClient {
public:
    using Clock = std::chrono::steady_clock;

    struct Counts {
        std::uint64_t calls = 0;
        std::uint64_t failures = 0;  ///< of these
        std::uint64_t damages = 0;   ///< keys that were reported as damaged
        double seconds = 0;          ///< that they took
    };

    /// Takes a line for the log.
    using Warn = std::function<void(const std::string&)>;

    /// @param deadline  of each call
    /// @param warn      takes the reports of damaged keys, from any thread; may be empty
    explicit RedisClient(RedisAddress address, std::chrono::milliseconds deadline = kDeadline, Warn warn = {});

    /// @returns  a reply for each command, none of which is an error
    Result<std::vector<RedisReply>> run(std::span<const RedisCommand> commands);
    Result<RedisReply> run(RedisCommand command);

    /// Runs a script, which Redis is told if it does not know it.
    /// @param key  on which it works
    Result<RedisReply> run(const RedisScript& script, std::string_view key, const RedisCommand& arguments);

    /// Logs and counts that a key held anything but what was written there.
    /// @param remedy  what becomes of it
    void report_damage(std::string_view key, std::string_view remedy);

    /// How Redis is set; empty where it does not tell.
    std::string setting(std::string_view name);

    Counts counts() const;
    const RedisAddress& address() const { return address_; }

    static constexpr std::chrono::milliseconds kDeadline{2'000};

private:
    using Connection = std::unique_ptr<RedisConnection>;

    /// A place among the connections in use.
    class Turn;

    Result<std::vector<RedisReply>> attempt(std::span<const RedisCommand> commands, Clock::time_point deadline);
    tl::unexpected<Error> late(const Error& error);
    void pause_locked(const Error& error);
    Connection take_idle();
    Result<Connection> connect(Clock::time_point deadline);
    void keep(Connection connection);
    void drop_idle();

    const RedisAddress address_;
    const std::chrono::milliseconds deadline_;
    const Warn warn_;

    mutable std::mutex mutex_;  ///< guards the rest
    std::condition_variable free_;
    std::size_t in_use_ = 0;
    std::vector<Connection> idle_;
    Clock::time_point retry_;  ///< not to be connected before
    std::chrono::milliseconds pause_{0};
    Error away_;  ///< why it could not be reached
    Counts counts_;
};

}  // namespace ccdt::server
