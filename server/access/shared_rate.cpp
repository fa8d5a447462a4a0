// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/shared_rate.h"

#include <charconv>

#include "server/redis/redis_script.h"

namespace ccdt::server {
namespace {

/// Prefix of the Redis keys. The number is the version of the stored layout.
constexpr std::string_view kPrefix = "ccdt:1:rate:";

/// Script that applies the rules of RateLimiter by the clock of Redis. The key of a full bucket expires.
const RedisScript kTake("allow-oom", {R"lua(
-- (tokens per second, capacity of a bucket) -> seconds until a token is available, or 0 if one was taken; 1 if the
-- bucket was damaged and therefore counts as full, otherwise 0
local rate, burst = tonumber(ARGV[1]), tonumber(ARGV[2])
local time = redis.call('TIME')
local now = time[1] + time[2] / 1000000
local damaged = 0
local found = redis.call('TYPE', KEYS[1]).ok
if found ~= 'hash' and found ~= 'none' then
    redis.call('UNLINK', KEYS[1])
    damaged = 1
end
local function number(name, default)
    local stored = redis.call('HGET', KEYS[1], name)
    local value = stored and tonumber(stored)
    if stored and (not value or value ~= value) then damaged = 1 end
    return value and value == value and value or default
end
local tokens, filled = number('tokens', burst), number('filled', now)
tokens = math.max(0, math.min(burst, tokens + math.max(now - filled, 0) * rate))
local wait = 0
if tokens >= 1 then tokens = tokens - 1 else wait = math.ceil((1 - tokens) / rate) end
redis.call('HSET', KEYS[1], 'tokens', tokens, 'filled', now)
redis.call('PEXPIRE', KEYS[1], math.ceil((burst - tokens) / rate * 1000) + 1)
return {wait, damaged}
)lua"});

}  // namespace

void SharedRate::set_rate(const RateLimiter::Rate& rate) {
    const std::lock_guard lock(mutex_);
    rate_ = rate;
}

std::optional<std::chrono::seconds> SharedRate::take(const std::string& client) {
    const auto [tokens, capacity] = [this] {
        const std::lock_guard lock(mutex_);
        return rate_;
    }();
    if (tokens <= 0) return std::chrono::seconds(0);
    char rate[32];
    const std::string_view per_second(rate, std::to_chars(std::begin(rate), std::end(rate), tokens).ptr);
    const std::string burst = std::to_string(capacity);
    const std::string key = std::string(kPrefix) + client;
    const auto reply = client_.run(kTake, key, {per_second, burst});
    if (!reply || reply->items.size() != 2) return std::nullopt;
    if (reply->items[1].number != 0) client_.report_damage(key, "the client has a full bucket again");
    return std::chrono::seconds(reply->items[0].number);
}

}  // namespace ccdt::server
