// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "api/run/options.h"
#include "server/redis/redis_client.h"

namespace ccdt::server {

/// A cache of answers in a Redis that several servers share. Every answer expires after a day. When its memory is full,
/// Redis chooses the answers to evict. Any failure of find() counts as a miss. Each entry has a digest, so that an
/// entry that another program has overwritten is detected and removed. Thread-safe.
class RedisCache {
public:
    /// `client` must outlive this object.
    explicit RedisCache(RedisClient& client) : client_(client) {}

    /// Describes settings of a Redis that will prevent it from storing answers. Skips settings that Redis does not
    /// permit to be read.
    /// Errors: Redis cannot be reached.
    static Result<std::vector<std::string>> find_faults(RedisClient& client);

    std::optional<api::Answer> find(const std::string& name);

    /// Stores an answer. Ignores bodies of more than `kLargest` bytes, because these would delay other calls.
    void store(const std::string& name, const api::Answer& answer);

    static constexpr std::size_t kLargest = std::size_t{4} << 20;

private:
    std::nullopt_t drop_damaged(const std::string& key);

    RedisClient& client_;
};

}  // namespace ccdt::server
