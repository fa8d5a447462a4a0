// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "server/processes/unique_fd.h"
#include "server/redis/redis_address.h"

struct redisReader;

namespace ccdt::server {

/// A command and its arguments, which may contain any bytes. The views must stay valid until the command is sent.
using RedisCommand = std::vector<std::string_view>;

/// A reply of Redis.
struct RedisReply {
    enum class Kind { Nothing, Text, Number, List, Error };

    Kind kind = Kind::Nothing;
    std::string text;               ///< text of a string, of a status or of an error
    std::int64_t number = 0;        ///< 0 for other kinds
    std::vector<RedisReply> items;  ///< the members of a list

    bool is_error(std::string_view code) const { return kind == Kind::Error && text.starts_with(code); }
};

/// A connection to a Redis server, for one thread at a time. After an error, the connection must be discarded.
///
/// Errors of all functions: Stopped if Redis cannot be reached or does not reply in time; Internal if a reply is
/// malformed. hiredis formats commands and parses replies; this class handles the socket, the deadlines and TLS.
class RedisConnection {
public:
    using Clock = std::chrono::steady_clock;

    /// Connects and authenticates. The deadline does not limit the name lookup.
    /// Errors (Stopped): Redis cannot be reached, or rejects the credentials or the number of the database.
    static Result<std::unique_ptr<RedisConnection>> open(const RedisAddress& address, Clock::time_point deadline);
    ~RedisConnection();

    RedisConnection(const RedisConnection&) = delete;
    RedisConnection& operator=(const RedisConnection&) = delete;

    Result<void> send(const RedisCommand& command, Clock::time_point deadline);

    /// Waits for the next reply, or message of a subscription.
    /// @returns  none if no reply is complete by `until`
    Result<std::optional<RedisReply>> receive(Clock::time_point until);

    /// Sends commands, and waits for all replies.
    Result<std::vector<RedisReply>> run(std::span<const RedisCommand> commands, Clock::time_point deadline);

private:
    class Tls;

    explicit RedisConnection(const RedisAddress& address);
    Result<void> connect(Clock::time_point deadline);
    Result<void> introduce(Clock::time_point deadline);
    Result<void> encrypt(Clock::time_point deadline);
    Result<void> send_bytes(std::string_view bytes, Clock::time_point deadline);
    Result<std::string_view> receive_bytes(Clock::time_point until);
    Result<std::optional<RedisReply>> take_reply();
    bool wait(short events, Clock::time_point until) const;
    tl::unexpected<Error> away(const std::string& why) const;

    const RedisAddress address_;
    UniqueFd socket_;
    std::unique_ptr<Tls> tls_;  ///< null: no TLS
    std::unique_ptr<redisReader, void (*)(redisReader*)> reader_;
    std::string received_;
};

}  // namespace ccdt::server
