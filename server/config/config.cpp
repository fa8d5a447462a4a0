// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/config/config.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string_view>
#include <thread>
#include <utility>

#include "api/text/text.h"
#include "server/config/memory_shares.h"
#include "server/flags/flag_values.h"
#include "server/flags/manual_page.h"
#include "server/http/hosts.h"
#include "server/processes/process.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kQueuePerWorker = 16;

/// Default number of connections in addition to those whose requests are computed or queued. They serve idle and slow
/// clients and requests that need no worker.
constexpr std::size_t kSpareConnections = 512;

/// Number of connections reserved for health checks and metrics: one for every kConnectionsPerReserved other
/// connections, and at least kMinReserve.
constexpr std::size_t kMinReserve = 16;
constexpr std::size_t kConnectionsPerReserved = 4;

/// Default limit in bytes for jobs on disk or in Redis.
constexpr std::size_t kJobBytes = std::size_t{1} << 30;

/// Values set by flags and variables. The optional members have defaults that depend on other values.
struct Draft {
    Config config;
    std::optional<std::size_t> workers;
    std::optional<std::size_t> threads_per_request;
    std::optional<std::size_t> queue;
    std::optional<std::size_t> connections;
    std::optional<std::size_t> memory;
    std::optional<std::size_t> job_bytes;
    std::optional<std::size_t> cache;
    std::optional<std::vector<std::string>> cors_origins;
    std::optional<std::vector<std::string>> allowed_hosts;
    std::map<std::string_view, ChosenValue> given;  ///< given values by the name of their flag
    std::vector<std::string> warnings;              ///< see CommandLine
};

/// Applies the value of a setting to a draft.
/// @returns  a description of the valid values; empty if the value is valid
using Apply = std::string (*)(Draft&, std::string_view value);

struct Setting {
    std::string_view flag;
    std::string_view variable;
    std::string_view value;
    std::string_view help;
    Apply apply;
    bool is_secret = false;         ///< error messages do not show the value
    bool only_by_variable = false;  ///< no flag, because the list of processes would show the value
    bool is_live = false;           ///< SIGHUP changes the value
};

/// Stores a parsed value.
/// @returns  as Apply
std::string store(std::size_t& target, const Result<std::size_t>& value) {
    if (!value) return value.error().message;
    target = *value;
    return {};
}

std::string set_whole(std::size_t& target, std::string_view text, std::uint64_t low, std::uint64_t high) {
    return store(target, parse_whole(text, low, high));
}

std::string set_bytes(std::size_t& target, std::string_view text, std::uint64_t low = 1) {
    return store(target, parse_bytes(text, low));
}

std::string set_seconds(std::chrono::milliseconds& target, std::string_view text) {
    constexpr double kMaxSeconds = 86'400;
    const auto seconds = api::parse_number<double>(text);
    if (!seconds || !(*seconds >= 0.001) || *seconds > kMaxSeconds) return "a number of seconds from 0.001 to 86400";
    target = std::chrono::milliseconds(static_cast<std::int64_t>(*seconds * 1000));
    return {};
}

std::string set_port(int& target, std::string_view text) {
    std::size_t port = 0;
    auto expected = set_whole(port, text, 0, 65'535);
    target = static_cast<int>(port);
    return expected;
}

std::string set_log_format(Draft& draft, std::string_view text) {
    if (text != "text" && text != "json") return "text or json";
    draft.config.log_format = text == "json" ? LogFormat::Json : LogFormat::Text;
    return {};
}

/// Whether a browser may send this text as the origin of a page. Accepts only visible ASCII, because it is sent back in
/// a header. Programs with pages of their own have schemes of their own.
bool is_page_origin(std::string_view text) {
    const auto is_of_origin = [](char c) { return c > ' ' && c < 0x7f && c != '*'; };
    const auto host = text.find("://");
    const bool has_host = host != std::string_view::npos && host > 0 && host + 3 < text.size();
    return text == "null" || (has_host && std::ranges::all_of(text, is_of_origin) &&
                              text.find_first_of("/@", host + 3) == std::string_view::npos);
}

/// Sets the allowed origins.
std::string set_cors_origins(Draft& draft, std::string_view text) {
    draft.cors_origins.emplace();
    if (text == "none") return {};
    while (true) {
        const auto origin = text.substr(0, text.find(','));
        if (origin != kAny && origin != kLoopback && !is_page_origin(origin))
            return "*, loopback, none, or origins such as https://example.org, separated by commas";
        draft.cors_origins->push_back(to_lower_case(origin));  // as browsers send it
        if (origin.size() == text.size()) return {};
        text.remove_prefix(origin.size() + 1);
    }
}

std::string set_allowed_hosts(Draft& draft, std::string_view text) {
    auto& hosts = draft.allowed_hosts.emplace();
    for (bool more = true; more;) {
        more = text.find(',') != std::string_view::npos;
        auto host = parse_host(api::take_until(text, ","));
        if (!host) return "names such as dots.example or addresses, without ports, separated by commas, or *";
        hosts.push_back(*std::move(host));
    }
    return {};
}

std::string set_targets(TargetHosts& target, std::string_view text) {
    auto hosts = TargetHosts::parse(text);
    if (!hosts)
        return "origins such as https://pictures.example, names, addresses, or networks such as 10.0.0.0/8, separated "
               "by commas";
    target = *std::move(hosts);
    return {};
}

std::string set_trusted_proxies(Draft& draft, std::string_view text) {
    TrustedProxies proxies;
    for (bool more = true; more;) {
        more = text.find(',') != std::string_view::npos;
        const auto one = api::take_until(text, ",");
        const auto network = IpNetwork::parse(one);
        if (!network && one != "unix") return "networks such as 10.0.0.0/8, addresses, or unix, separated by commas";
        if (network)
            proxies.networks.push_back(*network);
        else
            proxies.unix_socket = true;
    }
    draft.config.trusted_proxies = std::move(proxies);
    return {};
}

std::string set_rate(Draft& draft, std::string_view text) {
    constexpr double kMax = 1e6;
    const auto rate = api::parse_number<double>(text);
    if (!rate || !(*rate >= 0) || *rate > kMax) return "a number of requests per second from 0 to 1000000";
    draft.config.live.rate.per_second = *rate;
    return {};
}

std::string set_boolean(bool& target, std::string_view text) {
    if (text != "true" && text != "false") return "true or false";
    target = text == "true";
    return {};
}

std::string set_redis(std::optional<RedisAddress>& target, std::string_view text) {
#ifdef CCDT_WITHOUT_REDIS
    return "absent, because this server was built without Redis (CCDT_REDIS)";
#endif
    auto address = RedisAddress::parse(text);
    if (!address) return address.error().message;
    target = *std::move(address);
    return {};
}

std::string set_bind(Draft& draft, std::string_view text) {
    if (text.empty()) return "an address or host name";
    draft.config.bind = text;
    return {};
}

/// Returns the default origins: loopback if the server listens on loopback, otherwise none.
std::vector<std::string> default_cors_origins(std::string_view bind) {
    if (!is_loopback(bind)) return {};
    return {std::string(kLoopback)};
}

/// Returns the allowed hosts. If none are given and the server does not listen on loopback, any host is allowed.
/// Otherwise, the list includes loopback, because foreign pages cannot have loopback names (see allows_host).
std::vector<std::string> all_allowed_hosts(const Draft& draft) {
    if (!draft.allowed_hosts && !is_loopback(draft.config.bind)) return {std::string(kAny)};
    auto hosts = draft.allowed_hosts.value_or(std::vector<std::string>());
    hosts.emplace_back(kLoopback);
    return hosts;
}

constexpr auto kSettings = std::to_array<Setting>({
    {"--config", "CCDT_CONFIG", "FILE",
     "lines of name = value; flags and variables override it; SIGHUP reloads it (none)",
     [](Draft& draft, std::string_view text) {
         draft.config.file = text;
         return std::string(text.empty() ? "a file's name" : "");
     }},
    {"--port", "PORT", "N", "port to listen on, 0 for any free port (8080)",
     [](Draft& draft, std::string_view text) { return set_port(draft.config.port, text); }},
    {"--bind", "BIND", "ADDRESS", "address to listen on, or unix:PATH (127.0.0.1)", set_bind},
    {"--metrics-port", "CCDT_METRICS_PORT", "N",
     "port of /metrics, which then needs no key, 0 for any free port (none)",
     [](Draft& draft, std::string_view text) { return set_port(draft.config.metrics_port.emplace(), text); }},
    {"--workers", "CCDT_WORKERS", "N", "simultaneous computations (one per core, at most one per 96MiB of --memory)",
     [](Draft& draft, std::string_view text) { return set_whole(draft.workers.emplace(), text, 1, 1024); }},
    {"--threads-per-request", "CCDT_THREADS_PER_REQUEST", "N",
     "maximum threads of a request while other workers are idle (workers, at most one per core)",
     [](Draft& draft, std::string_view text) { return set_whole(draft.threads_per_request.emplace(), text, 1, 1024); }},
    {"--queue", "CCDT_QUEUE", "N", "requests that may wait for a worker (16 per worker)",
     [](Draft& draft, std::string_view text) { return set_whole(draft.queue.emplace(), text, 0, 4096); }},
    {"--max-body", "CCDT_MAX_BODY", "BYTES", "maximum size of a request body; accepts KiB, MiB and GiB (64MiB)",
     [](Draft& draft, std::string_view text) { return set_bytes(draft.config.max_body, text); }},
    {"--memory", "CCDT_MEMORY", "BYTES", "memory limit of the server (half of the machine's or the container's)",
     [](Draft& draft, std::string_view text) { return set_bytes(draft.memory.emplace(), text); }},
    {"--max-pixels", "CCDT_MAX_PIXELS", "N", "maximum pixels of a picture, read or drawn (64000000)",
     [](Draft& draft, std::string_view text) {
         return set_whole(draft.config.limits.max_pixels, text, 1, 1'000'000'000);
     }},
    {"--max-faces", "CCDT_MAX_FACES", "N", "maximum faces of a mesh, in triangles (4000000)",
     [](Draft& draft, std::string_view text) {
         return set_whole(draft.config.limits.max_faces, text, 1, 100'000'000);
     }},
    {"--max-sites", "CCDT_MAX_SITES", "N", "maximum sites of a request (2000000)",
     [](Draft& draft, std::string_view text) {
         return set_whole(draft.config.limits.max_sites, text, 1, 100'000'000);
     }},
    {"--timeout", "CCDT_TIMEOUT", "SECONDS", "time limit of an answer (60)",
     [](Draft& draft, std::string_view text) { return set_seconds(draft.config.timeout, text); }},
    {"--drain-timeout", "CCDT_DRAIN_TIMEOUT", "SECONDS", "time limit of the shutdown after SIGTERM (70)",
     [](Draft& draft, std::string_view text) { return set_seconds(draft.config.drain_timeout, text); }},
    {"--header-timeout", "CCDT_HEADER_TIMEOUT", "SECONDS", "time limit for the head of a request (10)",
     [](Draft& draft, std::string_view text) { return set_seconds(draft.config.patience.header, text); }},
    {"--body-timeout", "CCDT_BODY_TIMEOUT", "SECONDS",
     "longest pause of a client that sends a body or receives an answer (30)",
     [](Draft& draft, std::string_view text) { return set_seconds(draft.config.patience.body, text); }},
    {"--idle-timeout", "CCDT_IDLE_TIMEOUT", "SECONDS", "time that an idle connection is kept open (60)",
     [](Draft& draft, std::string_view text) { return set_seconds(draft.config.patience.idle, text); }},
    {"--max-connections", "CCDT_MAX_CONNECTIONS", "N", "maximum open connections (512 + workers + queue)",
     [](Draft& draft, std::string_view text) { return set_whole(draft.connections.emplace(), text, 1, 32'768); }},
    {"--max-streams", "CCDT_MAX_STREAMS", "N", "maximum event streams, besides these connections (1024)",
     [](Draft& draft, std::string_view text) { return set_whole(draft.config.capacity.streams, text, 0, 32'768); }},
    {"--max-connections-per-address", "CCDT_MAX_CONNECTIONS_PER_ADDRESS", "N",
     "connections per address, 0 for no limit (64)",
     [](Draft& draft, std::string_view text) { return set_whole(draft.config.capacity.per_address, text, 0, 32'768); }},
    {"--trusted-proxy", "CCDT_TRUSTED_PROXY", "NETWORKS", "proxies trusted to name clients; unix for Unix sockets",
     set_trusted_proxies},
    {"--data-dir", "CCDT_DATA_DIR", "FOLDER", "folder of the jobs, created if it is missing (in memory)",
     [](Draft& draft, std::string_view text) {
         draft.config.data_dir = text;
         return std::string(text.empty() ? "a folder's name" : "");
     }},
    {"--redis", "CCDT_REDIS", "URL", "Redis in which servers share jobs: redis://HOST or rediss://HOST (none)",
     [](Draft& draft, std::string_view text) { return set_redis(draft.config.redis, text); }, true},
    {"--job-lease", "CCDT_JOB_LEASE", "SECONDS", "time after which others take the jobs of a lost server (15)",
     [](Draft& draft, std::string_view text) { return set_seconds(draft.config.jobs.lease, text); }},
    {"--job-ttl", "CCDT_JOB_TTL", "SECONDS", "time that a job is kept after its end (3600)",
     [](Draft& draft, std::string_view text) { return set_seconds(draft.config.jobs.ttl, text); }},
    {"--job-timeout", "CCDT_JOB_TIMEOUT", "SECONDS", "time limit of a job (600)",
     [](Draft& draft, std::string_view text) { return set_seconds(draft.config.jobs.timeout, text); }},
    {"--job-queue", "CCDT_JOB_QUEUE", "N", "jobs that may wait (1000)",
     [](Draft& draft, std::string_view text) { return set_whole(draft.config.jobs.waiting, text, 0, 100'000); }},
    {"--job-bytes", "CCDT_JOB_BYTES", "BYTES",
     "storage for jobs (1GiB; in memory a sixteenth of --memory, at most 256MiB)",
     [](Draft& draft, std::string_view text) { return set_bytes(draft.job_bytes.emplace(), text); }},
    {"--webhook-host", "CCDT_WEBHOOK_HOST", "HOSTS",
     "hosts to which webhooks at the ends of jobs may be sent, separated by commas (none)",
     [](Draft& draft, std::string_view text) { return set_targets(draft.config.webhook_hosts, text); }},
    {"--webhook-key-file", "CCDT_WEBHOOK_KEY_FILE", "FILE",
     "lines of name:whsec_BASE64, which sign webhooks; SIGHUP reloads the file",
     [](Draft& draft, std::string_view text) {
         draft.config.webhook_key_file = text;
         return std::string(text.empty() ? "a file's name" : "");
     }},
    {"--cache", "CCDT_CACHE", "BYTES", "answers to keep, 0 for none (64MiB, at most a sixteenth of --memory)",
     [](Draft& draft, std::string_view text) { return set_bytes(draft.cache.emplace(), text, 0); }},
    {"--cache-shared", "CCDT_CACHE_SHARED", "BOOL", "true: API keys share answers, which timing reveals (false)",
     [](Draft& draft, std::string_view text) { return set_boolean(draft.config.cache_shared, text); }},
    {"--cache-redis", "CCDT_CACHE_REDIS", "URL", "Redis in which servers share answers (none)",
     [](Draft& draft, std::string_view text) { return set_redis(draft.config.cache_redis, text); }, true},
    {"--cors-origin", "CCDT_CORS_ORIGIN", "ORIGINS",
     "origins whose pages may call, separated by commas; * for all, loopback (default on loopback) or none",
     set_cors_origins, false, false, true},
    {"--allowed-host", "CCDT_ALLOWED_HOST", "HOSTS",
     "hosts that requests may name besides loopback, separated by commas; * for any (none on loopback, otherwise any)",
     set_allowed_hosts, false, false, true},
    {"--api-key-file", "CCDT_API_KEY_FILE", "FILE", "lines of name:key; clients need a key; SIGHUP reloads the file",
     [](Draft& draft, std::string_view text) {
         draft.config.api_key_file = text;
         return std::string(text.empty() ? "a file's name" : "");
     }},
    {"--presets", "CCDT_PRESETS", "FILE",
     "JSON of named options, for preset=NAME in requests; SIGHUP reloads it (none)",
     [](Draft& draft, std::string_view text) {
         draft.config.presets_file = text;
         return std::string(text.empty() ? "a file's name" : "");
     },
     false, false, true},
    {"--presets-only", "CCDT_PRESETS_ONLY", "BOOL", "true: requests must name a preset, without other options (false)",
     [](Draft& draft, std::string_view text) { return set_boolean(draft.config.presets_only, text); }},
    {"--pictures", "CCDT_PICTURES", "FOLDER", "folder of the pictures of GET /halftone/NAME (none)",
     [](Draft& draft, std::string_view text) {
         draft.config.pictures = text;
         return std::string(text.empty() ? "a folder's name" : "");
     }},
    {"--pictures-max-age", "CCDT_PICTURES_MAX_AGE", "SECONDS", "time for which caches may keep these halftones (60)",
     [](Draft& draft, std::string_view text) {
         std::size_t seconds = 0;
         auto expected = set_whole(seconds, text, 0, 31'536'000);
         draft.config.live.pictures_max_age = std::chrono::seconds(seconds);
         return expected;
     },
     false, false, true},
    {"--origin", "CCDT_ORIGIN", "ORIGINS",
     "origins of the pictures of POST /halftone?image_url=URL, separated by commas (none)",
     [](Draft& draft, std::string_view text) { return set_targets(draft.config.origins, text); }},
    {"--docs", "CCDT_DOCS", "FOLDER", "folder of the documentation that GET /docs/ serves (none)",
     [](Draft& draft, std::string_view text) {
         draft.config.docs = text;
         return std::string(text.empty() ? "a folder's name" : "");
     }},
    {"--signing-key-file", "CCDT_SIGNING_KEY_FILE", "FILE",
     "lines of name:key, with which the URLs of pictures must be signed; SIGHUP reloads the file",
     [](Draft& draft, std::string_view text) {
         draft.config.signing.file = text;
         return std::string(text.empty() ? "a file's name" : "");
     }},
    {"--signing-key", "CCDT_SIGNING_KEY", "KEY", "a signing key itself; only as a variable (none)",
     [](Draft& draft, std::string_view text) {
         draft.config.signing.key = text;
         return std::string();
     },
     true, true},
    {"--rate-limit", "CCDT_RATE_LIMIT", "N", "requests per second for each key or address, 0 for no limit (0)",
     set_rate, false, false, true},
    {"--rate-burst", "CCDT_RATE_BURST", "N", "requests that may arrive at once under a rate limit (20)",
     [](Draft& draft, std::string_view text) { return set_whole(draft.config.live.rate.burst, text, 1, 1'000'000); },
     false, false, true},
    {"--rate-redis", "CCDT_RATE_REDIS", "URL", "Redis in which servers count requests together (none)",
     [](Draft& draft, std::string_view text) { return set_redis(draft.config.rate_redis, text); }, true},
    {"--log-format", "CCDT_LOG_FORMAT", "FORMAT", "text or json (text)", set_log_format},
});

/// Flags that do something other than start the server, and their help texts.
struct ActionFlag {
    std::string_view flag;
    CommandLine::Action action;
    std::string_view help;
};
constexpr auto kActions = std::to_array<ActionFlag>({
    {"--check", CommandLine::Action::Check,
     "prints all values and what is wrong; exits with 1 if the server would not start"},
    {"--health", CommandLine::Action::Health,
     "asks the server on this address and port whether it is alive; exits with 1 if not"},
    {"--help", CommandLine::Action::Help, "prints the list of options"},
    {"--manual", CommandLine::Action::Manual, "prints the manual page, for man(1)"},
    {"--print-config", CommandLine::Action::PrintConfig,
     "prints a file for --config with all values; defaults and passwords are comments"},
    {"--version", CommandLine::Action::Version, "prints the version"},
});

/// Whether an action works even if settings are invalid.
bool needs_no_settings(CommandLine::Action action) {
    using Action = CommandLine::Action;
    return action == Action::Help || action == Action::Version || action == Action::Manual;
}

constexpr std::string_view kVariables =
    "Each option may also be given as the environment variable beside it, or in the file of --config. A flag overrides "
    "its variable, and both override the file.";

/// Replaces the password in a text such as `redis://user:password@host` by asterisks.
std::string without_password(std::string_view text) {
    const auto scheme = text.find("://");
    const auto end = text.rfind('@');
    if (scheme == std::string_view::npos || end == std::string_view::npos) return std::string(text);
    const auto colon = text.find(':', scheme + 3);
    if (colon >= end) return std::string(text);
    return std::string(text.substr(0, colon + 1)) + "***" + std::string(text.substr(end));
}

/// Writes a number of bytes with a unit, unless that would round it.
std::string with_unit(const std::string& value) {
    const std::size_t bytes = *parse_bytes(value, 0);
    const std::string text = format_bytes(bytes);
    const auto parsed = parse_bytes(text, 0);
    return parsed && *parsed == bytes ? text : value;
}

/// Applies a value.
/// @param name    name of the setting for error messages
/// @param origin  see ChosenValue
Result<void> apply(const Setting& setting, std::string_view name, std::string_view value, std::string_view origin,
                   Draft& draft) {
    const std::string expected = setting.apply(draft, value);
    if (expected.empty()) {
        std::string shown = setting.only_by_variable ? "***" : without_password(value);
        if (setting.value == "BYTES") shown = with_unit(shown);
        draft.given.insert_or_assign(setting.flag,
                                     ChosenValue{setting.flag, shown, std::string(origin), std::string(value)});
        return {};
    }
    if (setting.is_secret) return failure(ErrorCode::Malformed, std::string(name) + ": " + expected);
    return failure(ErrorCode::Malformed, std::string(name) + ": '" + std::string(value) + "' is not " + expected);
}

/// Lists a name of each setting.
std::vector<std::string> list_settings(std::string_view (*name_of)(const Setting&)) {
    std::vector<std::string> names;
    names.reserve(kSettings.size());
    for (const Setting& setting : kSettings) names.emplace_back(name_of(setting));
    return names;
}

std::string warn_of_variable(std::string_view name) {
    const auto names = list_settings([](const Setting& setting) { return setting.variable; });
    return "the variable " + std::string(name) + " has no effect; " + suggestion(names, name);
}

Result<void> read_environment(std::span<const char* const> environment, Draft& draft) {
    for (std::string_view value : environment) {
        const auto name = api::take_until(value, "=");
        if (value.empty()) continue;
        const auto setting = std::ranges::find(kSettings, name, &Setting::variable);
        if (setting == kSettings.end()) {
            if (name.starts_with("CCDT_")) draft.warnings.push_back(warn_of_variable(name));
        } else if (auto taken = apply(*setting, name, value, name, draft); !taken) {
            return taken;
        }
    }
    return {};
}

std::vector<std::string> all_flags() {
    auto flags = list_settings([](const Setting& setting) { return setting.flag; });
    for (const ActionFlag& each : kActions) flags.emplace_back(each.flag);
    return flags;
}

Result<CommandLine::Action> read_flags(std::span<const char* const> arguments, Draft& draft) {
    auto action = CommandLine::Action::Serve;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::string_view argument = arguments[i];
        const auto other = std::ranges::find(kActions, argument == "-h" ? "--help" : argument, &ActionFlag::flag);
        if (other != kActions.end()) {
            action = other->action;
            if (needs_no_settings(action)) return action;
            continue;
        }
        const auto equals = argument.find('=');
        const auto name = argument.substr(0, equals);
        const auto setting = std::ranges::find(kSettings, name, &Setting::flag);
        if (setting == kSettings.end())
            return failure(ErrorCode::Malformed,
                           "'" + std::string(name) + "' is not an option; " + suggestion(all_flags(), name));
        if (setting->only_by_variable)
            return failure(ErrorCode::Malformed, std::string(name) +
                                                     ": the list of processes would show the key; use " +
                                                     std::string(setting->variable) + " or --signing-key-file");
        const bool attached = equals != std::string_view::npos;
        if (!attached && ++i == arguments.size())
            return failure(ErrorCode::Malformed, std::string(name) + " needs a value");
        const auto value = attached ? argument.substr(equals + 1) : std::string_view(arguments[i]);
        if (auto taken = apply(*setting, name, value, name, draft); !taken) return tl::unexpected(taken.error());
    }
    return action;
}

/// Returns the name of a setting in a file.
std::string_view file_name_of(const Setting& setting) {
    return setting.flag.substr(2);
}

/// Reads a file of settings. Leaves settings unchanged that have a value already.
/// @param file  name of the file, for messages
Result<void> read_settings(std::string_view text, const std::string& file, Draft& draft) {
    std::map<std::string_view, std::size_t> lines;
    const auto given_before = draft.given;
    for (std::size_t number = 1; !text.empty(); ++number) {
        auto value = api::trim(api::take_until(text, "\n"), " \t\r");
        if (value.empty() || value.starts_with('#')) continue;
        const std::string origin = file + ':' + std::to_string(number);
        if (value.find('=') == std::string_view::npos)
            return failure(ErrorCode::Malformed, origin + ": the line is not of the form name = value");
        const auto name = api::trim(api::take_until(value, "="), " \t");
        value = api::trim(value, " \t");
        const auto setting = std::ranges::find_if(
            kSettings, [name](const Setting& each) { return name == file_name_of(each) || name == each.variable; });
        if (setting == kSettings.end())
            return failure(ErrorCode::Malformed, origin + ": '" + std::string(name) + "' is not an option; " +
                                                     suggestion(list_settings(file_name_of), name));
        if (const auto [line, is_new] = lines.emplace(setting->flag, number); !is_new)
            return failure(ErrorCode::Malformed,
                           origin + ": " + std::string(name) + " is given in line " + std::to_string(line->second));
        if (value.empty() || given_before.contains(setting->flag)) continue;
        if (auto taken = apply(*setting, origin + ": " + std::string(name), value, origin, draft); !taken) return taken;
    }
    return {};
}

Result<Presets> read_presets(const std::string& file, const ReadFile& read_file) {
    return read_file(file).and_then([&](const std::string& text) {
        return Presets::parse(text).map_error([&](Error error) {
            error.message.insert(0, file + ": ");
            return error;
        });
    });
}

/// Returns the default value of a setting: the text in parentheses at the end of its help text.
std::string default_of(const Setting& setting) {
    const auto open = setting.help.rfind('(');
    if (open == std::string_view::npos || !setting.help.ends_with(')')) return {};
    return std::string(setting.help.substr(open + 1, setting.help.size() - open - 2));
}

/// Lists the values of all flags, including computed defaults.
std::vector<ChosenValue> chosen_values(const Draft& draft) {
    const Config& config = draft.config;
    const std::map<std::string_view, std::string> computed{
        {"--workers", std::to_string(config.workers)},
        {"--threads-per-request", std::to_string(config.threads_per_request)},
        {"--queue", std::to_string(config.queue)},
        {"--max-connections", std::to_string(config.capacity.connections)},
        {"--memory", format_bytes(config.memory)},
        {"--cache", format_bytes(config.cache)},
        {"--job-bytes", format_bytes(config.jobs.bytes)},
        {"--cors-origin", config.live.cors_origins.empty() ? "none" : config.live.cors_origins.front()},
        {"--allowed-host", config.live.allowed_hosts.front()},
    };
    std::vector<ChosenValue> values;
    for (const Setting& setting : kSettings) {
        const auto given = draft.given.find(setting.flag);
        const auto derived = computed.find(setting.flag);
        if (given != draft.given.end())
            values.push_back(given->second);
        else
            values.push_back({setting.flag, derived == computed.end() ? default_of(setting) : derived->second, {}, {}});
    }
    return values;
}

/// Pads a text with blanks to the width of a column, with at least one blank.
std::string padded(std::string_view text, std::size_t width) {
    std::string cell(text);
    cell.resize(std::max(cell.size() + 1, width), ' ');
    return cell;
}

}  // namespace

bool is_path(std::string_view bind) {
    return bind.starts_with("unix:");
}

std::string bind_of_metrics(const Config& config) {
    return is_path(config.bind) ? "127.0.0.1" : config.bind;
}

Result<CommandLine> parse_command_line(std::span<const char* const> arguments, std::span<const char* const> environment,
                                       const ReadFile& read_file) {
    // Reads the flags first, so that --help works even if the environment is invalid.
    Draft flags;
    const auto action = read_flags(arguments, flags);
    if (!action) return tl::unexpected(action.error());
    if (needs_no_settings(*action)) return CommandLine{*action, {}, {}, {}};

    Draft draft;
    const std::size_t cores = std::max<std::size_t>(1, std::thread::hardware_concurrency());
    if (auto read = read_environment(environment, draft); !read) return tl::unexpected(read.error());
    if (auto read = read_flags(arguments, draft); !read) return tl::unexpected(read.error());
    if (const std::string file = draft.config.file; !file.empty()) {
        const auto text = read_file(file);
        if (!text) return tl::unexpected(text.error());
        if (auto read = read_settings(*text, file, draft); !read) return tl::unexpected(read.error());
    }
    if (const std::string& file = draft.config.presets_file; !file.empty()) {
        auto presets = read_presets(file, read_file);
        if (!presets) return tl::unexpected(presets.error());
        draft.config.live.presets = *std::move(presets);
    } else if (draft.config.presets_only) {
        return failure(ErrorCode::Malformed, "--presets-only needs --presets");
    }
    draft.config.live.cors_origins = draft.cors_origins.value_or(default_cors_origins(draft.config.bind));
    draft.config.live.allowed_hosts = all_allowed_hosts(draft);
    if (draft.config.redis && !draft.config.data_dir.empty())
        return failure(ErrorCode::Malformed, "--data-dir and --redis: only one of them may be given");
    if (draft.config.webhook_hosts.names.empty() != draft.config.webhook_key_file.empty())
        return failure(ErrorCode::Malformed, "--webhook-host and --webhook-key-file: one needs the other");
    if (!draft.config.signing.file.empty() && !draft.config.signing.key.empty())
        return failure(ErrorCode::Malformed, "--signing-key-file and CCDT_SIGNING_KEY: only one of them may be given");
    draft.config.memory = draft.memory.value_or(default_memory(available_memory()));
    draft.config.workers = draft.workers.value_or(default_workers(cores, draft.config.memory));
    draft.config.threads_per_request = draft.threads_per_request.value_or(std::min(draft.config.workers, cores));
    draft.config.queue = draft.queue.value_or(kQueuePerWorker * draft.config.workers);
    auto& capacity = draft.config.capacity;
    capacity.connections = draft.connections.value_or(kSpareConnections + draft.config.workers + draft.config.queue);
    capacity.reserve = std::max(kMinReserve, capacity.connections / kConnectionsPerReserved);
    const MemoryShares shares = share_memory(draft.config.memory, draft.config.max_body);
    capacity.bytes = shares.transfers;
    draft.config.cache = draft.cache.value_or(shares.cache);
    const bool in_memory = draft.config.data_dir.empty() && !draft.config.redis;
    draft.config.jobs.bytes = draft.job_bytes.value_or(in_memory ? shares.jobs : kJobBytes);
    return CommandLine{*action, draft.config, chosen_values(draft), draft.warnings};
}

std::string usage() {
    std::string text =
        "Usage: ccdt-server [options]\n"
        "Serves halftones and point sets of equal capacity over HTTP.\n\n";
    for (const Setting& setting : kSettings) {
        const std::string flag = "  " + std::string(setting.flag) + ' ' + std::string(setting.value);
        text += padded(flag, 35) + padded(setting.variable, 33) + std::string(setting.help) + '\n';
    }
    for (const auto& [flag, action, help] : kActions)
        text += padded("  " + std::string(flag), 68) + std::string(help) + '\n';
    return text + '\n' + std::string(kVariables) + '\n';
}

std::string manual() {
    ManualPage page("ccdt-server", 8, "serves halftones and evenly spread points over HTTP");
    page.begin_section("SYNOPSIS");
    page.add_paragraph("ccdt-server [OPTION]...");
    page.begin_section("DESCRIPTION");
    page.add_paragraph(
        "Answers requests for halftones, evenly spread points and their analysis until SIGTERM or SIGINT arrives. It "
        "then accepts no new connections, and answers the requests that have arrived. SIGHUP reloads the "
        "file of --config, the presets and the key files; the log names changed settings that need a restart.");
    page.begin_section("OPTIONS");
    page.add_paragraph(kVariables);
    for (const Setting& setting : kSettings) {
        const std::string variable = "Variable: " + std::string(setting.variable) + '.';
        if (setting.only_by_variable)
            page.add_option(setting.variable, {}, setting.help);
        else
            page.add_option(setting.flag, setting.value, std::string(setting.help) + ". " + variable);
    }
    for (const auto& [flag, action, help] : kActions) page.add_option(flag, {}, help);
    page.begin_section("EXIT STATUS");
    page.add_option("0", {}, "The server was stopped by a signal, or --check or --health found no fault.");
    page.add_option("1", {}, "The server could not start, or failed; --check or --health found a fault.");
    page.add_option("2", {}, "An option or a variable is not valid.");
    page.begin_section("SEE ALSO");
    page.add_paragraph("ccdt(1)");
    return page.text();
}

std::string config_file(const std::vector<ChosenValue>& values) {
    std::string text = "# Settings of ccdt-server " CCDT_VERSION ", for its flag --config\n";
    for (const auto& [flag, value, origin, given] : values) {
        const Setting& setting = *std::ranges::find(kSettings, flag, &Setting::flag);
        if (flag == kSettings.front().flag) continue;  // a file cannot name another file
        const bool is_shown = !setting.only_by_variable && without_password(given) == given;
        text += "\n# " + std::string(setting.help) + '\n' + (given.empty() || !is_shown ? "#" : "") +
                std::string(file_name_of(setting)) + " = " + value + '\n';
    }
    return text;
}

std::string changes_for_restart(const std::vector<ChosenValue>& before, const std::vector<ChosenValue>& after) {
    std::string flags;
    for (std::size_t i = 0; i < kSettings.size(); ++i) {
        const bool is_same = before[i].value == after[i].value && before[i].given == after[i].given;
        if (kSettings[i].is_live || is_same) continue;
        flags += (flags.empty() ? "" : ", ") + std::string(kSettings[i].flag);
    }
    return flags;
}

std::string describe(const std::vector<ChosenValue>& values) {
    std::string lines;
    for (const auto& [flag, value, origin, given] : values)
        lines += "  " + padded(flag, 33) + padded(value.empty() ? "none" : value, 25) +
                 (origin.empty() ? "default" : origin) + '\n';
    return lines;
}

}  // namespace ccdt::server
