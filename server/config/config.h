#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "core/result.h"
#include "server/access/gate.h"
#include "server/access/rate_limiter.h"
#include "server/http/capacity.h"
#include "server/http/connection.h"
#include "server/http/hosts.h"
#include "server/http/proxies.h"
#include "server/jobs/job_limits.h"
#include "server/redis/redis_address.h"

namespace ccdt::server {

enum class LogFormat { Text, Json };

struct Config {
    std::string bind = "127.0.0.1";
    int port = 8080;                               ///< 0: any that is free
    std::size_t workers = 1;                       ///< computations at once
    std::size_t threads_per_request = 1;           ///< most that a computation is lent while others idle
    std::size_t queue = 16;                        ///< requests that may wait for a worker
    std::size_t max_body = std::size_t{64} << 20;  ///< bytes
    std::size_t memory = std::size_t{1} << 30;     ///< bytes, of the whole program and its decoders
    api::Limits limits;
    std::chrono::milliseconds timeout{60'000};        ///< from a request's last byte to its answer
    std::chrono::milliseconds drain_timeout{70'000};  ///< from the signal to end to the end
    Patience patience;                                ///< with slow clients
    Capacity::Limits capacity;                        ///< for all clients together
    TrustedProxies trusted_proxies;                   ///< that are believed for whom they ask
    JobLimits jobs;
    std::size_t cache = 0;                    ///< bytes of answers to keep; 0: none
    bool cache_shared = false;                ///< what is kept for one API key is given to all
    std::optional<RedisAddress> cache_redis;  ///< where servers share answers
    std::optional<RedisAddress> rate_redis;   ///< where servers count requests together
    std::string data_dir;                     ///< where jobs are kept; empty: in memory, or in Redis
    std::optional<RedisAddress> redis;        ///< where jobs are kept that servers share
    std::vector<std::string> cors_origins;    ///< whose pages may call, as cors_headers takes them; empty: none
    std::vector<std::string> allowed_hosts{std::string(kAny)};  ///< that may be asked for, as allows_host takes them
    std::string api_key_file;                                   ///< empty: whoever asks is answered
    std::string pictures;                                       ///< folder of those asked for by name; empty: none are
    Gate::SigningKeys signing;                                  ///< empty: pictures are asked for by any URL
    RateLimiter::Rate rate;                                     ///< of requests, for each key or address
    LogFormat log_format = LogFormat::Text;
};

/// A flag's value, and where it comes from.
struct ChosenValue {
    std::string_view flag;
    std::string value;        ///< as it was given, without the password of a URL; empty: none, by default
    std::string_view origin;  ///< the flag or the variable; empty: the default
};

struct CommandLine {
    enum class Action {
        Serve,
        Check,   ///< whether it could
        Health,  ///< whether one does
        Help,
        Version
    };
    Action action = Action::Serve;
    Config config;
    std::vector<ChosenValue> values;  ///< one for each flag, to be shown
};

/// Looks up an environment variable; null if it is not set.
using Environment = std::function<const char*(const char* name)>;

/// Reads the flags and the environment; a flag wins. An empty variable counts as not set.
///
/// @param arguments  without the program's name; `--flag value` and `--flag=value`
/// Errors (Malformed): an unknown flag, a flag without its value, a value out of range. The message names it.
Result<CommandLine> parse_command_line(std::span<const char* const> arguments, const Environment& environment);

/// The text that --help prints.
std::string usage();

/// A line for each flag: its value, and where that comes from.
std::string describe(const std::vector<ChosenValue>& values);

}  // namespace ccdt::server
