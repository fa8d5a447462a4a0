// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/config/config.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

namespace ccdt::server {
namespace {

using Variables = std::map<std::string, std::string>;

/// @param file  content of every file of settings
Result<CommandLine> parse(const std::vector<const char*>& arguments, const Variables& variables = {},
                          const std::string& file = {}) {
    std::vector<std::string> texts;
    for (const auto& [name, value] : variables) texts.push_back(name + '=' + value);
    std::vector<const char*> environment;
    for (const auto& text : texts) environment.push_back(text.c_str());
    return parse_command_line(arguments, environment, [&](const std::string&) { return file; });
}

TEST(Config, HasTheDocumentedDefaults) {
    const auto parsed = parse({});
    ASSERT_TRUE(parsed);
    const Config& config = parsed->config;
    EXPECT_EQ(parsed->action, CommandLine::Action::Serve);
    EXPECT_EQ(config.port, 8080);
    EXPECT_EQ(config.bind, "127.0.0.1");
    EXPECT_GE(config.workers, 1u);
    EXPECT_EQ(config.threads_per_request, config.workers);
    EXPECT_EQ(config.queue, 16 * config.workers);
    EXPECT_EQ(config.max_body, std::size_t{64} << 20);
    EXPECT_EQ(config.limits.max_pixels, 64'000'000u);
    EXPECT_EQ(config.limits.max_sites, 2'000'000u);
    EXPECT_EQ(config.limits.max_faces, 4'000'000u);
    EXPECT_EQ(config.timeout, std::chrono::seconds(60));
    EXPECT_EQ(config.patience.header, std::chrono::seconds(10));
    EXPECT_EQ(config.patience.body, std::chrono::seconds(30));
    EXPECT_EQ(config.patience.idle, std::chrono::seconds(60));
    EXPECT_EQ(config.capacity.connections, 512 + config.workers + config.queue);
    EXPECT_EQ(config.capacity.reserve, config.capacity.connections / 4);
    EXPECT_EQ(config.capacity.streams, 1024u);
    EXPECT_EQ(config.capacity.per_address, 64u);
    EXPECT_EQ(config.capacity.bytes, std::size_t{256} << 20);
    EXPECT_EQ(config.cache, std::min(std::size_t{64} << 20, (config.memory - (std::size_t{192} << 20)) / 16));
    EXPECT_EQ(config.data_dir, "");
    EXPECT_EQ(config.jobs.waiting, 1000u);
    EXPECT_EQ(config.jobs.bytes, std::min(std::size_t{256} << 20, (config.memory - (std::size_t{192} << 20)) / 16));
    EXPECT_EQ(config.jobs.ttl, std::chrono::hours(1));
    EXPECT_EQ(config.jobs.timeout, std::chrono::minutes(10));
    EXPECT_EQ(config.live.cors_origins, std::vector<std::string>{"loopback"});
    EXPECT_EQ(config.api_key_file, "");
    EXPECT_EQ(config.live.rate.per_second, 0);
    EXPECT_EQ(config.live.rate.burst, 20u);
    EXPECT_EQ(config.log_format, LogFormat::Text);
}

TEST(Config, ReadsFlagsInBothSpellings) {
    const auto parsed =
        parse({"--port=81", "--bind", "0.0.0.0", "--workers=3", "--queue", "0", "--max-body=2MiB", "--max-pixels=1000",
               "--max-sites", "77", "--max-faces=88", "--timeout=1.5", "--cors-origin", "*", "--log-format=json"});
    ASSERT_TRUE(parsed) << parsed.error().message;
    const Config& config = parsed->config;
    EXPECT_EQ(config.port, 81);
    EXPECT_EQ(config.bind, "0.0.0.0");
    EXPECT_EQ(config.workers, 3u);
    EXPECT_EQ(config.queue, 0u);
    EXPECT_EQ(config.max_body, std::size_t{2} << 20);
    EXPECT_EQ(config.limits.max_pixels, 1000u);
    EXPECT_EQ(config.limits.max_sites, 77u);
    EXPECT_EQ(config.limits.max_faces, 88u);
    EXPECT_EQ(config.timeout, std::chrono::milliseconds(1500));
    EXPECT_EQ(config.live.cors_origins, std::vector<std::string>{"*"});
    EXPECT_EQ(config.log_format, LogFormat::Json);
}

TEST(Config, AllowsLoopbackOriginsIfBoundToLoopback) {
    const auto origins = [](const std::vector<const char*>& flags) { return parse(flags)->config.live.cors_origins; };
    for (const char* bind : {"127.0.0.1", "::1", "localhost"})
        EXPECT_EQ(origins({"--bind", bind}), std::vector<std::string>{"loopback"}) << bind;
    for (const char* bind : {"0.0.0.0", "::", "10.0.0.1", "unix:/run/socket"})
        EXPECT_TRUE(origins({"--bind", bind}).empty()) << bind;
    EXPECT_TRUE(origins({"--cors-origin=none"}).empty());
    EXPECT_EQ(origins({"--cors-origin=https://a.example"}), std::vector<std::string>{"https://a.example"});
    EXPECT_EQ(origins({"--cors-origin=https://A.example,null,loopback,app://id"}),
              (std::vector<std::string>{"https://a.example", "null", "loopback", "app://id"}));
}

TEST(Config, AllowsOnlyLoopbackHostsIfBoundToLoopback) {
    using Hosts = std::vector<std::string>;
    const auto hosts = [](const std::vector<const char*>& flags) { return parse(flags)->config.live.allowed_hosts; };
    for (const char* bind : {"127.0.0.1", "::1", "localhost"})
        EXPECT_EQ(hosts({"--bind", bind}), Hosts{"loopback"}) << bind;
    for (const char* bind : {"0.0.0.0", "::", "10.0.0.1", "unix:/run/socket"})
        EXPECT_EQ(hosts({"--bind", bind}), Hosts{"*"}) << bind;
    for (const char* bind : {"127.0.0.1", "0.0.0.0"}) {
        EXPECT_EQ(hosts({"--bind", bind, "--allowed-host=Dots.Example,10.0.0.1,[fd00:0::1]"}),
                  (Hosts{"dots.example", "10.0.0.1", "fd00::1", "loopback"}));
        EXPECT_EQ(hosts({"--bind", bind, "--allowed-host=*"}), (Hosts{"*", "loopback"}));
    }
    EXPECT_EQ(parse({}, {{"CCDT_ALLOWED_HOST", "a"}})->config.live.allowed_hosts, (Hosts{"a", "loopback"}));
}

TEST(Config, ReadsTheEnvironment) {
    const auto parsed = parse({}, {{"PORT", "81"},
                                   {"BIND", "::"},
                                   {"CCDT_WORKERS", "2"},
                                   {"CCDT_QUEUE", "5"},
                                   {"CCDT_MAX_BODY", "512KiB"},
                                   {"CCDT_MAX_PIXELS", "9"},
                                   {"CCDT_MAX_SITES", "8"},
                                   {"CCDT_TIMEOUT", "2"},
                                   {"CCDT_CORS_ORIGIN", "https://example.org"},
                                   {"CCDT_LOG_FORMAT", "json"}});
    ASSERT_TRUE(parsed) << parsed.error().message;
    const Config& config = parsed->config;
    EXPECT_EQ(config.port, 81);
    EXPECT_EQ(config.bind, "::");
    EXPECT_EQ(config.workers, 2u);
    EXPECT_EQ(config.queue, 5u);
    EXPECT_EQ(config.max_body, std::size_t{512} << 10);
    EXPECT_EQ(config.limits.max_pixels, 9u);
    EXPECT_EQ(config.limits.max_sites, 8u);
    EXPECT_EQ(config.timeout, std::chrono::seconds(2));
    EXPECT_EQ(config.live.cors_origins, std::vector<std::string>{"https://example.org"});
    EXPECT_EQ(config.log_format, LogFormat::Json);
}

TEST(Config, ReadsTheLimitsOnClients) {
    const auto parsed = parse({"--header-timeout=1", "--body-timeout=2", "--idle-timeout=0.5", "--max-connections=7",
                               "--max-streams=0", "--max-connections-per-address=0", "--max-body=1GiB",
                               "--memory=100GiB", "--cors-origin=https://a.example,http://b:81", "--api-key-file=keys",
                               "--rate-limit=0.5", "--rate-burst=3"});
    ASSERT_TRUE(parsed) << parsed.error().message;
    const Config& config = parsed->config;
    EXPECT_EQ(config.patience.header, std::chrono::seconds(1));
    EXPECT_EQ(config.patience.body, std::chrono::seconds(2));
    EXPECT_EQ(config.patience.idle, std::chrono::milliseconds(500));
    EXPECT_EQ(config.capacity.connections, 7u);
    EXPECT_EQ(config.capacity.reserve, 16u);
    EXPECT_EQ(config.capacity.streams, 0u);
    EXPECT_EQ(config.capacity.per_address, 0u);
    EXPECT_EQ(config.capacity.bytes, std::size_t{4} << 30);
    EXPECT_EQ(config.memory, std::size_t{100} << 30);
    EXPECT_EQ(config.live.cors_origins, (std::vector<std::string>{"https://a.example", "http://b:81"}));
    EXPECT_EQ(config.api_key_file, "keys");
    EXPECT_EQ(config.live.rate.per_second, 0.5);
    EXPECT_EQ(config.live.rate.burst, 3u);
}

/// Returns `value|origin` of a flag, as shown by --check.
std::string shown(const Result<CommandLine>& parsed, std::string_view flag) {
    const auto found = std::ranges::find(parsed->values, flag, &ChosenValue::flag);
    if (found == parsed->values.end()) return "?";
    return found->value + '|' + std::string(found->origin);
}

TEST(Config, ShowsWhereValuesComeFrom) {
    const auto parsed = parse({"--check", "--port=81", "--queue=5"},
                              {{"BIND", "::"}, {"PORT", "80"}, {"CCDT_WORKERS", "3"}, {"CCDT_JOB_BYTES", "1MiB"}});
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_EQ(parsed->action, CommandLine::Action::Check);
    EXPECT_EQ(parsed->config.port, 81);
    EXPECT_EQ(shown(parsed, "--port"), "81|--port");
    EXPECT_EQ(shown(parsed, "--bind"), "::|BIND");
    EXPECT_EQ(shown(parsed, "--workers"), "3|CCDT_WORKERS");
    EXPECT_EQ(shown(parsed, "--job-bytes"), "1MiB|CCDT_JOB_BYTES");
    EXPECT_EQ(shown(parsed, "--max-connections"), "520|");
    EXPECT_EQ(shown(parsed, "--cors-origin"), "none|");
    EXPECT_EQ(shown(parsed, "--allowed-host"), "*|");
    EXPECT_EQ(shown(parse({}), "--cors-origin"), "loopback|");
    EXPECT_EQ(shown(parse({}), "--allowed-host"), "loopback|");
    EXPECT_EQ(shown(parse({"--memory=1073741824"}), "--memory"), "1GiB|--memory");
    EXPECT_EQ(shown(parse({"--memory=1073741825"}), "--memory"), "1073741825|--memory");
    EXPECT_EQ(shown(parse({"--memory=1GiB"}), "--cache"), "52MiB|");
    EXPECT_EQ(shown(parse({"--memory=1050000KiB"}), "--job-bytes"), "52.1MiB|");
    EXPECT_EQ(shown(parsed, "--timeout"), "60|");
    EXPECT_EQ(shown(parsed, "--api-key-file"), "|");
}

TEST(Config, HidesPasswords) {
    const auto value = [](const char* address) { return shown(parse({"--docs", address}), "--docs"); };
    EXPECT_EQ(value("redis://user:secret@host:6379/0"), "redis://user:***@host:6379/0|--docs");
    EXPECT_EQ(value("redis://:a:b@c@host"), "redis://:***@host|--docs");
    EXPECT_EQ(value("redis://user@host:6379"), "redis://user@host:6379|--docs");
    EXPECT_EQ(value("https://host:80"), "https://host:80|--docs");
}

TEST(Config, ReadsTrustedProxies) {
    const auto parsed = parse({"--trusted-proxy=10.0.0.0/8,fd00::/8,192.0.2.1,unix"});
    ASSERT_TRUE(parsed) << parsed.error().message;
    const TrustedProxies& proxies = parsed->config.trusted_proxies;
    EXPECT_TRUE(proxies.unix_socket);
    std::vector<std::string> networks;
    for (const IpNetwork& network : proxies.networks) networks.push_back(network.text());
    EXPECT_EQ(networks, (std::vector<std::string>{"10.0.0.0/8", "fd00::/8", "192.0.2.1/32"}));
    EXPECT_EQ(parse({}, {{"CCDT_TRUSTED_PROXY", "::1"}})->config.trusted_proxies.networks.size(), 1u);
    EXPECT_TRUE(parse({})->config.trusted_proxies.networks.empty());
    for (const char* value : {"", ",", "10.0.0.0/8,", "10.0.0.0/33", "balancer", "10.0.0.0/8, ::1", "UNIX"})
        EXPECT_FALSE(parse({"--trusted-proxy", value})) << value;
}

TEST(Config, ReadsTheDocumentationFolder) {
    EXPECT_EQ(parse({})->config.docs, "");
    EXPECT_EQ(parse({"--docs", "site"})->config.docs, "site");
    EXPECT_EQ(parse({}, {{"CCDT_DOCS", "site"}})->config.docs, "site");
}

TEST(Config, ReadsThePictureFolderAndSigningKeys) {
    EXPECT_EQ(parse({})->config.pictures, "");
    EXPECT_TRUE(parse({})->config.signing.empty());
    const auto by_file = parse({"--pictures=photos", "--signing-key-file=keys"});
    ASSERT_TRUE(by_file) << by_file.error().message;
    EXPECT_EQ(by_file->config.pictures, "photos");
    EXPECT_EQ(by_file->config.signing.file, "keys");
    const auto by_variable = parse({}, {{"CCDT_PICTURES", "photos"}, {"CCDT_SIGNING_KEY", "se:cr@et"}});
    ASSERT_TRUE(by_variable) << by_variable.error().message;
    EXPECT_EQ(by_variable->config.signing.key, "se:cr@et");
    EXPECT_EQ(shown(by_variable, "--signing-key"), "***|CCDT_SIGNING_KEY");
    EXPECT_EQ(shown(parse({}), "--signing-key"), "none|");
}

TEST(Config, RefusesASigningKeyAsAFlag) {
    for (const auto& flags : {std::vector{"--signing-key=se:cret"}, std::vector{"--signing-key", "se:cret"},
                              std::vector{"--signing-key"}}) {
        const auto parsed = parse(flags);
        ASSERT_FALSE(parsed);
        EXPECT_NE(parsed.error().message.find("CCDT_SIGNING_KEY"), std::string::npos) << parsed.error().message;
        EXPECT_EQ(parsed.error().message.find("cret"), std::string::npos) << parsed.error().message;
    }
}

TEST(Config, ReadsTheLimitsOnJobs) {
    const auto parsed = parse({"--data-dir=jobs", "--job-ttl=5", "--job-queue=0"}, {{"CCDT_JOB_TIMEOUT", "7"}});
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_EQ(parsed->config.data_dir, "jobs");
    EXPECT_EQ(parsed->config.jobs.ttl, std::chrono::seconds(5));
    EXPECT_EQ(parsed->config.jobs.waiting, 0u);
    EXPECT_EQ(parsed->config.jobs.timeout, std::chrono::seconds(7));
    EXPECT_EQ(parsed->config.jobs.bytes, std::size_t{1} << 30);
    EXPECT_EQ(parse({"--job-bytes=3MiB"})->config.jobs.bytes, std::size_t{3} << 20);
    EXPECT_EQ(parse({"--memory=1GiB"})->config.jobs.bytes, std::size_t{52} << 20);
}

TEST(Config, ReadsTheRedisAddress) {
    const auto parsed = parse({"--redis=redis://:secret@example.org:7000", "--job-lease=2", "--memory=1GiB"});
    ASSERT_TRUE(parsed) << parsed.error().message;
    ASSERT_TRUE(parsed->config.redis);
    EXPECT_EQ(parsed->config.redis->name(), "example.org:7000");
    EXPECT_EQ(parsed->config.jobs.lease, std::chrono::seconds(2));
    EXPECT_FALSE(parsed->config.cache_redis || parsed->config.rate_redis) << "each must be configured explicitly";
    EXPECT_EQ(parsed->config.jobs.bytes, std::size_t{1} << 30);
    const auto wrong = parse({"--redis=redis://:secret@a:99999"});
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().message.find("secret"), std::string::npos) << wrong.error().message;
}

TEST(Config, DerivesTheCacheSizeFromTheMemory) {
    EXPECT_EQ(parse({"--memory=8GiB"})->config.cache, std::size_t{64} << 20);
    EXPECT_EQ(parse({"--memory=512MiB"})->config.cache, std::size_t{20} << 20);
    EXPECT_EQ(parse({"--cache=3MiB"})->config.cache, std::size_t{3} << 20);
    EXPECT_EQ(parse({"--cache=0"}, {{"CCDT_CACHE", "1MiB"}})->config.cache, 0u);
    EXPECT_FALSE(parse({})->config.cache_shared);
    EXPECT_TRUE(parse({}, {{"CCDT_CACHE_SHARED", "true"}})->config.cache_shared);
    EXPECT_FALSE(parse({"--cache-shared=yes"}));
}

TEST(Config, ReadsAFileOfSettings) {
    const char* const file = R"(# a comment
max-body = 2MiB

  CCDT_QUEUE=5	
port = 81
workers = 3
pictures =
signing-key = a = b # c
)";
    const auto parsed = parse({"--config=a", "--workers=4"}, {{"PORT", "82"}}, file);
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_EQ(shown(parsed, "--max-body"), "2MiB|a:2");
    EXPECT_EQ(shown(parsed, "--queue"), "5|a:4");
    EXPECT_EQ(shown(parsed, "--port"), "82|PORT");
    EXPECT_EQ(shown(parsed, "--workers"), "4|--workers");
    EXPECT_EQ(shown(parsed, "--pictures"), "none|");
    EXPECT_EQ(parsed->config.signing.key, "a = b # c");
    EXPECT_EQ(parsed->config.max_body, std::size_t{2} << 20);
    EXPECT_EQ(parse({}, {{"CCDT_CONFIG", "a"}}, "rate-burst = 7")->config.live.rate.burst, 7u);
}

TEST(Config, ReadsThePortOfMetrics) {
    EXPECT_FALSE(parse({})->config.metrics_port);
    const auto parsed = parse({"--metrics-port=0", "--bind=unix:/run/socket"});
    EXPECT_EQ(parsed->config.metrics_port, 0);
    EXPECT_EQ(bind_of_metrics(parsed->config), "127.0.0.1");
    EXPECT_EQ(bind_of_metrics(parse({"--bind=::"})->config), "::");
}

TEST(Config, ReadsWebhookHosts) {
    const auto parsed = parse({"--webhook-host=Hooks.example,10.0.0.0/8", "--webhook-key-file=keys"});
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_EQ(parsed->config.webhook_hosts.names, std::vector<std::string>{"hooks.example"});
    EXPECT_EQ(parsed->config.webhook_hosts.networks.size(), 1u);
    EXPECT_EQ(parsed->config.webhook_key_file, "keys");
    EXPECT_TRUE(parse({})->config.webhook_hosts.names.empty());
}

TEST(Config, ReadsPresets) {
    const auto parsed = parse({"--presets=a", "--presets-only=true"}, {}, R"({"x": {"sites": 1}})");
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_EQ(parsed->config.live.presets.names(), std::vector<std::string>{"x"});
    EXPECT_TRUE(parsed->config.presets_only);
    EXPECT_FALSE(parse({})->config.presets_only);
}

TEST(Config, NamesTheInvalidLineOfAFile) {
    const std::pair<const char*, const char*> wrongs[] = {
        {"\nwokers = 3", "a:2: 'wokers' is not an option; did you mean workers?"},
        {"CCDT_WORKER = 3", "a:1: 'CCDT_WORKER' is not an option; --help lists the options"},
        {"workers", "a:1: the line is not of the form name = value"},
        {"--workers = 3", "a:1: '--workers' is not an option"},
        {"workers = many", "a:1: workers: 'many' is not a whole number"},
        {"port = 1\nPORT = 2", "a:2: PORT is given in line 1"},
        {"redis = redis://:secret@a:99999", "a:1: redis: "},
    };
    for (const auto& [file, message] : wrongs) {
        const auto parsed = parse({"--config=a"}, {}, file);
        ASSERT_FALSE(parsed) << file;
        EXPECT_TRUE(parsed.error().message.starts_with(message)) << parsed.error().message;
        EXPECT_EQ(parsed.error().message.find("secret"), std::string::npos);
    }
    const auto missing = parse_command_line(std::vector{"--config=/none"}, {});
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().message, "/none: cannot be read");
}

TEST(Config, PrintsAFileThatSetsTheSameValues) {
    const auto parsed = parse({"--max-body=3000000", "--allowed-host=a,b", "--redis=redis://:secret@a", "--config=a"},
                              {{"CCDT_SIGNING_KEY", "secret"}, {"CCDT_CACHE", "1MiB"}}, "cors-origin = *\n");
    ASSERT_TRUE(parsed) << parsed.error().message;
    const std::string file = config_file(parsed->values);
    EXPECT_EQ(file.find("secret"), std::string::npos) << file;
    const auto again = parse({"--config=b"}, {}, file);
    ASSERT_TRUE(again) << again.error().message;
    for (const ChosenValue& value : parsed->values) {
        const auto line = file.find('\n' + std::string(value.flag.substr(2)) + " = ");
        const bool is_set = line != std::string::npos;
        const bool is_given = !value.origin.empty() && value.value.find("***") == std::string::npos;
        EXPECT_EQ(is_set, is_given && value.flag != "--config") << value.flag;
        EXPECT_EQ(shown(again, value.flag).starts_with(value.value + "|b:"), is_set) << value.flag;
    }
    // Without the hash signs, the defaults are valid values, or words in the place of none.
    EXPECT_NE(file.find("\n#timeout = 60\n"), std::string::npos) << file;
}

TEST(Config, ListsChangesThatNeedARestart) {
    const auto changes = [](const std::string& before, const std::string& after) {
        return changes_for_restart(parse({"--config=a"}, {}, before)->values, parse({"--config=a"}, {}, after)->values);
    };
    EXPECT_EQ(changes("port = 81\nrate-limit = 1", "port = 81\nrate-burst = 3\ncors-origin = *\nallowed-host = a"), "");
    EXPECT_EQ(changes("port = 81\nworkers = 1", "timeout = 5\nworkers = 1"), "--port, --timeout");
    EXPECT_EQ(changes("redis = redis://:a@host", "redis = redis://:b@host"), "--redis");
}

TEST(Config, WarnsOfUnknownVariables) {
    const auto parsed = parse({}, {{"CCDT_WORKER", "3"}, {"CCDT_HOME", "/"}, {"CCDT_EMPTY", ""}, {"PROT", "81"}});
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_EQ(parsed->warnings,
              (std::vector<std::string>{"the variable CCDT_HOME has no effect; --help lists the options",
                                        "the variable CCDT_WORKER has no effect; did you mean CCDT_WORKERS?"}));
}

TEST(Config, PrefersFlagsToTheEnvironment) {
    const auto parsed = parse({"--port", "81"}, {{"PORT", "82"}, {"CCDT_WORKERS", "2"}});
    ASSERT_TRUE(parsed);
    EXPECT_EQ(parsed->config.port, 81);
    EXPECT_EQ(parsed->config.queue, 32u) << "the queue's default follows the number of workers";
}

TEST(Config, LimitsWorkersToTheMemory) {
    EXPECT_EQ(parse({"--memory=64MiB"})->config.workers, 1U);
    EXPECT_EQ(parse({"--memory=64MiB", "--workers=9"})->config.workers, 9U);
}

TEST(Config, LimitsThreadsPerRequestToWorkersAndCores) {
    const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
    EXPECT_EQ(parse({"--workers=1"})->config.threads_per_request, 1U);
    EXPECT_EQ(parse({"--workers=1000"})->config.threads_per_request, std::min<std::size_t>(cores, 1000));
    EXPECT_EQ(shown(parse({"--workers=1"}), "--threads-per-request"), "1|");
    EXPECT_EQ(parse({"--workers=1", "--threads-per-request=7"})->config.threads_per_request, 7U);
    EXPECT_EQ(parse({}, {{"CCDT_THREADS_PER_REQUEST", "5"}})->config.threads_per_request, 5U);
}

TEST(Config, IgnoresEmptyVariables) {
    const auto parsed = parse({}, {{"PORT", ""}, {"CCDT_CORS_ORIGIN", ""}});
    ASSERT_TRUE(parsed);
    EXPECT_EQ(parsed->config.port, 8080);
}

TEST(Config, ShowsHelpDespiteOtherErrors) {
    EXPECT_EQ(parse({"--help"}, {{"PORT", "x"}})->action, CommandLine::Action::Help);
    EXPECT_EQ(parse({"--version"})->action, CommandLine::Action::Version);
    EXPECT_EQ(parse({"--manual"})->action, CommandLine::Action::Manual);
}

TEST(Config, ListsEveryFlagAndVariableInTheHelp) {
    const std::string text = usage();
    for (const char* word : {"--config",
                             "CCDT_CONFIG",
                             "--print-config",
                             "--metrics-port",
                             "CCDT_METRICS_PORT",
                             "--pictures-max-age",
                             "CCDT_PICTURES_MAX_AGE",
                             "--origin",
                             "CCDT_ORIGIN",
                             "--webhook-host",
                             "CCDT_WEBHOOK_HOST",
                             "--webhook-key-file",
                             "CCDT_WEBHOOK_KEY_FILE",
                             "--presets",
                             "CCDT_PRESETS",
                             "--presets-only",
                             "CCDT_PRESETS_ONLY",
                             "--port",
                             "PORT",
                             "--bind",
                             "BIND",
                             "--workers",
                             "CCDT_WORKERS",
                             "--threads-per-request",
                             "CCDT_THREADS_PER_REQUEST",
                             "--queue",
                             "CCDT_QUEUE",
                             "--max-body",
                             "CCDT_MAX_BODY",
                             "--max-pixels",
                             "CCDT_MAX_PIXELS",
                             "--max-faces",
                             "CCDT_MAX_FACES",
                             "--max-sites",
                             "CCDT_MAX_SITES",
                             "--timeout",
                             "CCDT_TIMEOUT",
                             "--header-timeout",
                             "CCDT_HEADER_TIMEOUT",
                             "--body-timeout",
                             "CCDT_BODY_TIMEOUT",
                             "--idle-timeout",
                             "CCDT_IDLE_TIMEOUT",
                             "--max-connections",
                             "CCDT_MAX_CONNECTIONS",
                             "--max-streams",
                             "CCDT_MAX_STREAMS",
                             "--max-connections-per-address",
                             "CCDT_MAX_CONNECTIONS_PER_ADDRESS",
                             "--data-dir",
                             "CCDT_DATA_DIR",
                             "--redis",
                             "CCDT_REDIS",
                             "--cache-redis",
                             "CCDT_CACHE_REDIS",
                             "--rate-redis",
                             "CCDT_RATE_REDIS",
                             "--job-lease",
                             "CCDT_JOB_LEASE",
                             "--job-ttl",
                             "CCDT_JOB_TTL",
                             "--job-timeout",
                             "CCDT_JOB_TIMEOUT",
                             "--job-queue",
                             "CCDT_JOB_QUEUE",
                             "--job-bytes",
                             "CCDT_JOB_BYTES",
                             "--cors-origin",
                             "CCDT_CORS_ORIGIN",
                             "--allowed-host",
                             "CCDT_ALLOWED_HOST",
                             "--api-key-file",
                             "CCDT_API_KEY_FILE",
                             "--pictures",
                             "CCDT_PICTURES",
                             "--docs",
                             "CCDT_DOCS",
                             "--signing-key-file",
                             "CCDT_SIGNING_KEY_FILE",
                             "CCDT_SIGNING_KEY",
                             "--rate-limit",
                             "CCDT_RATE_LIMIT",
                             "--rate-burst",
                             "CCDT_RATE_BURST",
                             "--log-format",
                             "CCDT_LOG_FORMAT",
                             "--help",
                             "--manual",
                             "--version"})
        EXPECT_NE(text.find(word), std::string::npos) << word;
}

struct Wrong {
    std::vector<const char*> arguments;
    Variables variables;
    const char* named;
};

TEST(Config, NamesTheInvalidFlagOrVariable) {
    const Wrong wrongs[] = {
        {{"--nonsense"}, {}, "'--nonsense' is not an option; --help lists the options"},
        {{"--wokers=3"}, {}, "'--wokers' is not an option; did you mean --workers?"},
        {{"--helth"}, {}, "did you mean --health?"},
        {{"8080"}, {}, "8080"},
        {{"--port"}, {}, "--port"},
        {{"--port", "65536"}, {}, "--port"},
        {{"--port=-1"}, {}, "--port"},
        {{"--port="}, {}, "--port"},
        {{"--port=80x"}, {}, "--port"},
        {{"--workers=0"}, {}, "--workers"},
        {{"--threads-per-request=0"}, {}, "--threads-per-request"},
        {{"--max-body=0"}, {}, "--max-body"},
        {{"--max-body=1TiB"}, {}, "--max-body"},
        {{"--max-body=99999999999GiB"}, {}, "--max-body"},
        {{"--max-sites=0"}, {}, "--max-sites"},
        {{"--timeout=0"}, {}, "--timeout"},
        {{"--timeout=nan"}, {}, "--timeout"},
        {{"--timeout=1e9"}, {}, "--timeout"},
        {{"--cors-origin=a\r\nb"}, {}, "--cors-origin"},
        {{"--cors-origin=https://a.example,"}, {}, "--cors-origin"},
        {{"--cors-origin=a.example"}, {}, "--cors-origin"},
        {{"--cors-origin=https://a.example/"}, {}, "--cors-origin"},
        {{"--cors-origin=https://*.example"}, {}, "--cors-origin"},
        {{"--origin=https://*.example"}, {}, "--origin"},
        {{"--allowed-host=*.example"}, {}, "--allowed-host"},
        {{"--allowed-host="}, {}, "--allowed-host"},
        {{"--allowed-host=a:80"}, {}, "--allowed-host"},
        {{"--allowed-host=http://a"}, {}, "--allowed-host"},
        {{"--allowed-host=a,,b"}, {}, "--allowed-host"},
        {{"--allowed-host=[a]"}, {}, "--allowed-host"},
        {{"--header-timeout=0"}, {}, "--header-timeout"},
        {{"--max-connections=0"}, {}, "--max-connections"},
        {{"--max-streams=x"}, {}, "--max-streams"},
        {{"--api-key-file="}, {}, "--api-key-file"},
        {{"--config="}, {}, "--config"},
        {{"--presets="}, {}, "--presets"},
        {{"--metrics-port=65536"}, {}, "--metrics-port"},
        {{"--pictures-max-age=-1"}, {}, "--pictures-max-age"},
        {{"--presets=a"}, {}, "a: "},
        {{"--presets-only=yes"}, {}, "--presets-only"},
        {{"--presets-only=true"}, {}, "--presets-only needs --presets"},
        {{"--webhook-host=https://a/b"}, {}, "--webhook-host"},
        {{"--origin=ftp://a"}, {}, "--origin"},
        {{"--webhook-host=a"}, {}, "--webhook-key-file"},
        {{"--webhook-key-file=a"}, {}, "--webhook-host"},
        {{"--data-dir="}, {}, "--data-dir"},
        {{"--pictures="}, {}, "--pictures"},
        {{"--docs="}, {}, "--docs"},
        {{"--signing-key-file="}, {}, "--signing-key-file"},
        {{"--signing-key-file=a"}, {{"CCDT_SIGNING_KEY", "b"}}, "--signing-key-file and CCDT_SIGNING_KEY"},
        {{"--redis=http://a"}, {}, "--redis"},
        {{}, {{"CCDT_REDIS", "redis-sentinel://a"}}, "CCDT_REDIS"},
        {{"--redis=redis://a", "--data-dir=b"}, {}, "--data-dir and --redis"},
        {{"--job-lease=0"}, {}, "--job-lease"},
        {{"--cache-redis=x"}, {}, "--cache-redis"},
        {{"--rate-redis=x"}, {}, "--rate-redis"},
        {{"--job-ttl=0"}, {}, "--job-ttl"},
        {{"--job-timeout=x"}, {}, "--job-timeout"},
        {{"--job-queue=-1"}, {}, "--job-queue"},
        {{"--job-bytes=0"}, {}, "--job-bytes"},
        {{"--rate-limit=-1"}, {}, "--rate-limit"},
        {{"--rate-limit=nan"}, {}, "--rate-limit"},
        {{"--rate-burst=0"}, {}, "--rate-burst"},
        {{"--log-format=xml"}, {}, "--log-format"},
        {{"--bind="}, {}, "--bind"},
        {{}, {{"CCDT_QUEUE", "many"}}, "CCDT_QUEUE"},
    };
    for (const Wrong& wrong : wrongs) {
        const auto parsed = parse(wrong.arguments, wrong.variables);
        ASSERT_FALSE(parsed) << wrong.named;
        EXPECT_NE(parsed.error().message.find(wrong.named), std::string::npos) << parsed.error().message;
    }
}

}  // namespace
}  // namespace ccdt::server
