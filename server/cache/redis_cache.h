#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "api/run/options.h"
#include "server/redis/redis_client.h"

namespace ccdt::server {

/// Answers in a Redis, where servers share them. What goes first when its memory is full Redis decides; after a day all
/// do. An answer that cannot be had, for whatever reason, is none. One that others have written over is removed:
/// entries have digests. May be used from any thread.
class RedisCache {
public:
    /// The client must outlive it.
    explicit RedisCache(RedisClient& client) : client_(client) {}

    /// Finds what of the settings of a Redis keeps answers out of it, as far as it tells them. Errors: it cannot be
    /// reached.
    static Result<std::vector<std::string>> find_faults(RedisClient& client);

    std::optional<api::Answer> find(const std::string& name);

    /// Keeps an answer of at most `kLargest` bytes: others would wait for larger ones.
    void keep(const std::string& name, const api::Answer& answer);

    static constexpr std::size_t kLargest = std::size_t{4} << 20;

private:
    std::nullopt_t drop_damaged(const std::string& key);

    RedisClient& client_;
};

}  // namespace ccdt::server
