#include "server/access/shared_rate.h"

#include <charconv>

#include "server/redis/redis_script.h"

namespace ccdt::server {
namespace {

/// Before the clients; the number is the version of what is kept.
constexpr std::string_view kPrefix = "ccdt:1:rate:";

/// As RateLimiter does, by the clock of Redis; a bucket that is full is none.
const RedisScript kTake("allow-oom", {R"lua(
-- tokens a second, tokens in a full bucket -> seconds until there is a token, 0 if one was taken
local rate, burst = tonumber(ARGV[1]), tonumber(ARGV[2])
local time = redis.call('TIME')
local now = time[1] + time[2] / 1000000
local tokens = tonumber(redis.call('HGET', KEYS[1], 'tokens') or burst)
local filled = tonumber(redis.call('HGET', KEYS[1], 'filled') or now)
tokens = math.min(burst, tokens + math.max(now - filled, 0) * rate)
local wait = 0
if tokens >= 1 then tokens = tokens - 1 else wait = math.ceil((1 - tokens) / rate) end
redis.call('HSET', KEYS[1], 'tokens', tokens, 'filled', now)
redis.call('PEXPIRE', KEYS[1], math.ceil((burst - tokens) / rate * 1000) + 1)
return wait
)lua"});

}  // namespace

std::optional<std::chrono::seconds> SharedRate::take(const std::string& client) {
    if (rate_.per_second <= 0) return std::chrono::seconds(0);
    char rate[32];
    const std::string_view per_second(rate, std::to_chars(std::begin(rate), std::end(rate), rate_.per_second).ptr);
    const std::string burst = std::to_string(rate_.burst);
    const auto wait = client_.run(kTake, std::string(kPrefix) + client, {per_second, burst});
    return wait ? std::optional(std::chrono::seconds(wait->number)) : std::nullopt;
}

}  // namespace ccdt::server
