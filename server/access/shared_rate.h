#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "server/access/rate_limiter.h"
#include "server/redis/redis_client.h"

namespace ccdt::server {

/// Buckets of tokens in a Redis, one for each client over all servers, as RateLimiter has them for one. May be used
/// from any thread.
class SharedRate {
public:
    /// The client must outlive it.
    SharedRate(RedisClient& client, const RateLimiter::Rate& rate) : client_(client), rate_(rate) {}

    /// Takes a token. A bucket that others have written over is reported, and taken for full.
    /// @returns  0 if the request may pass, else after how many seconds there will be a token; none if Redis does not
    ///           tell
    std::optional<std::chrono::seconds> take(const std::string& client);

private:
    RedisClient& client_;
    const RateLimiter::Rate rate_;
};

}  // namespace ccdt::server
