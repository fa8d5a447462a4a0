// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "api/run/options.h"
#include "server/redis/redis_client.h"

namespace ccdt::server {

/// A cache of answers in a Redis that several servers share. When the memory of Redis is full, Redis chooses the
/// answers to evict. Every answer expires after a day. An answer that cannot be retrieved, for whatever reason, counts
/// as absent. Entries have digests, so an entry that another program has overwritten is detected and removed.
/// Thread-safe.
class RedisCache {
public:
    /// `client` must outlive this object.
    explicit RedisCache(RedisClient& client) : client_(client) {}

    /// Lists the settings of a Redis that prevent it from storing answers, as far as Redis reveals them.
    /// Errors: Redis cannot be reached.
    static Result<std::vector<std::string>> find_faults(RedisClient& client);

    std::optional<api::Answer> find(const std::string& name);

    /// Stores an answer unless its body exceeds `kLargest` bytes. A larger answer would delay other calls.
    void store(const std::string& name, const api::Answer& answer);

    static constexpr std::size_t kLargest = std::size_t{4} << 20;

private:
    std::nullopt_t drop_damaged(const std::string& key);

    RedisClient& client_;
};

}  // namespace ccdt::server
