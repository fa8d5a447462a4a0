// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>

#include "server/access/rate_limiter.h"
#include "server/redis/redis_client.h"

namespace ccdt::server {

/// Token buckets in a Redis that several servers share. Each client has one bucket, which follows the rules of
/// RateLimiter. Thread-safe.
class SharedRate {
public:
    /// `client` must outlive this object.
    SharedRate(RedisClient& client, const RateLimiter::Rate& rate) : client_(client), rate_(rate) {}

    /// Changes the rate, as RateLimiter::set_rate().
    void set_rate(const RateLimiter::Rate& rate);

    /// Takes a token. Reports a damaged bucket, and replaces it with a full bucket.
    /// @returns  0 if a token was available, otherwise the number of seconds until one is; none if Redis does not reply
    std::optional<std::chrono::seconds> take(const std::string& client);

private:
    RedisClient& client_;

    std::mutex mutex_;  ///< guards the rate
    RateLimiter::Rate rate_;
};

}  // namespace ccdt::server
