// SPDX-License-Identifier: GPL-3.0-or-later
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
#include "core/base/result.h"
#include "server/access/access_control.h"
#include "server/access/rate_limiter.h"
#include "server/files/text_file.h"
#include "server/http/capacity.h"
#include "server/http/connection.h"
#include "server/http/hosts.h"
#include "server/http/proxies.h"
#include "server/jobs/job_limits.h"
#include "server/redis/redis_address.h"
#include "server/requests/presets.h"

namespace ccdt::server {

enum class LogFormat { Text, Json };

/// Values that SIGHUP changes in a running server.
struct LiveConfig {
    std::vector<std::string> cors_origins;  ///< origins whose pages may use the server: cors_headers
    std::vector<std::string> allowed_hosts{std::string(kAny)};  ///< hosts allowed in `Host`: see allows_host
    RateLimiter::Rate rate;                                     ///< limit of requests for each key or address
    std::chrono::seconds pictures_max_age{60};                  ///< time for which caches keep pictures by name
    Presets presets;                                            ///< named options of requests
};

struct Config {
    std::string file;  ///< file of settings; empty: none
    std::string bind = "127.0.0.1";
    int port = 8080;                               ///< 0: any free port
    std::optional<int> metrics_port;               ///< port of /metrics; 0: any free port; none: that of the rest
    std::size_t workers = 1;                       ///< number of computations at the same time
    std::size_t threads_per_request = 1;           ///< threads that a computation may use while other workers are idle
    std::size_t queue = 16;                        ///< number of requests that may wait for a worker
    std::size_t max_body = std::size_t{64} << 20;  ///< bytes
    std::size_t memory = std::size_t{1} << 30;     ///< limit in bytes for the server, computations and decoders
    api::Limits limits;
    std::chrono::milliseconds timeout{60'000};        ///< maximum time from the last byte of a request to its answer
    std::chrono::milliseconds drain_timeout{70'000};  ///< maximum time from SIGTERM to the end of the process
    Patience patience;                                ///< time-outs for slow clients
    Capacity::Limits capacity;                        ///< limits for all clients together
    TrustedProxies trusted_proxies;                   ///< proxies whose headers about their clients are trusted
    JobLimits jobs;
    std::size_t cache = 0;                    ///< capacity for answers, in bytes; 0: no cache
    bool cache_shared = false;                ///< answers computed for one API key are also sent to other keys
    std::optional<RedisAddress> cache_redis;  ///< Redis in which servers share answers
    std::optional<RedisAddress> rate_redis;   ///< Redis in which servers share the rate limits of clients
    std::string data_dir;                     ///< folder of the job database; empty: jobs are in memory or in Redis
    std::optional<RedisAddress> redis;        ///< Redis in which servers share jobs
    LiveConfig live;
    std::string api_key_file;            ///< file of API keys; empty: no key is needed
    std::string presets_file;            ///< file of LiveConfig::presets; empty: none
    bool presets_only = false;           ///< requests must name a preset and give no options
    std::string pictures;                ///< folder of pictures requested by name; empty: none
    std::string docs;                    ///< folder served under /docs/; empty: none
    AccessControl::SigningKeys signing;  ///< empty: pictures by name need no signature
    TargetHosts origins;                 ///< hosts of pictures that clients request by URL; none: no such pictures
    TargetHosts webhook_hosts;           ///< hosts to which webhooks may be sent; none: no webhooks
    std::string webhook_key_file;        ///< file of the keys that sign webhooks
    LogFormat log_format = LogFormat::Text;
};

/// Whether a value of `bind` is the path of a Unix socket.
bool is_path(std::string_view bind);

/// Returns the address of the port of the metrics: that of the server, or loopback if the server has a path.
std::string bind_of_metrics(const Config& config);

/// The value of a flag, and the origin of the value.
struct ChosenValue {
    std::string_view flag;
    std::string value;   ///< value for display, without passwords; empty: no value
    std::string origin;  ///< name of the flag or the variable, or file and line; empty: the default
    std::string given;   ///< value as given, which may contain a password; empty: the default
};

/// Reads a file of the operator.
using ReadFile = std::function<Result<std::string>(const std::string& path)>;

struct CommandLine {
    enum class Action {
        Serve,
        Check,   ///< check whether the server could start
        Health,  ///< check whether a running server is alive
        Help,
        Manual,       ///< print the manual page
        PrintConfig,  ///< print a file of settings
        Version
    };
    Action action = Action::Serve;
    Config config;
    std::vector<ChosenValue> values;    ///< one for each flag, for display
    std::vector<std::string> warnings;  ///< variables that begin with `CCDT_` and are not known
};

/// Reads the flags, the environment variables and the file of settings. A flag overrides its variable, which overrides
/// the file. An empty variable, or an empty value in the file, counts as not set.
///
/// The file has lines `name = value`. A name is that of a flag without its hyphens, such as `max-body`, or that of a
/// variable. Empty lines and lines that begin with # are ignored.
///
/// @param arguments    without the program's name, as `--flag value` or `--flag=value`
/// @param environment  all variables, as `NAME=value`
/// @param read_file    reads the file of settings
/// Errors (Malformed): an unknown flag, a flag without a value, a value out of range. The message names the flag, or
/// the line of the file. Errors of `read_file`.
Result<CommandLine> parse_command_line(std::span<const char* const> arguments, std::span<const char* const> environment,
                                       const ReadFile& read_file = read_text_file);

/// Returns the text that --help prints.
std::string usage();

/// Returns the manual page that --manual prints, in roff.
std::string manual();

/// Returns a file of settings with all values. Defaults, and values with passwords, are comments.
std::string config_file(const std::vector<ChosenValue>& values);

/// Lists the flags whose values differ and cannot be changed in a running server, separated by commas.
/// @param before, after  values of two command lines
std::string changes_for_restart(const std::vector<ChosenValue>& before, const std::vector<ChosenValue>& after);

/// Returns one line for each flag: its value and origin.
std::string describe(const std::vector<ChosenValue>& values);

}  // namespace ccdt::server
