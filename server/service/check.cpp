// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/check.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stop_token>
#include <string_view>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "server/access/access_control.h"
#include "server/access/key_ring.h"
#include "server/cache/redis_cache.h"
#include "server/compute/compute_supervisor.h"
#include "server/config/descriptor_plan.h"
#include "server/config/memory_plan.h"
#include "server/decoder/decoder_supervisor.h"
#include "server/files/file_folder.h"
#include "server/http/sockets.h"
#include "server/jobs/redis_job_store.h"
#include "server/processes/child_program.h"
#include "server/processes/process.h"
#include "server/redis/redis_client.h"
#include "server/webhooks/webhooks.h"

namespace ccdt::server {
namespace {

using State = Finding::State;

constexpr std::size_t kColumn = 10;

/// The state of a part and its description.
using Found = std::pair<State, std::string>;

Found wrong(const Error& error) {
    return {State::Wrong, error.message};
}

void ignore_report(const std::string& /*message*/) {}

Found check_decoder(const Config& /*config*/) {
    const auto supervisor = DecoderSupervisor::start(
        [](UniqueFd orders) { return spawn_sibling("ccdt-decoder", std::move(orders)); }, ignore_report);
    if (!supervisor) return wrong(supervisor.error());
    if (const auto ready = (*supervisor)->wait_until_ready(); !ready) return wrong(ready.error());
    const Confinement& confinement = (*supervisor)->confinement();
    return {confinement.is_whole() ? State::Good : State::Weak, confinement.describe()};
}

Found check_worker(const Config& config) {
    const auto supervisor =
        ComputeSupervisor::start([](UniqueFd socket) { return spawn_sibling("ccdt-worker", std::move(socket)); },
                                 {.limits = config.limits}, [](const Order&, const std::stop_token&) {}, ignore_report);
    if (!supervisor) return wrong(supervisor.error());
    if (const auto ready = (*supervisor)->wait_until_ready(); !ready) return wrong(ready.error());
    return {State::Good, std::to_string(config.workers) + " simultaneous computations"};
}

Found check_keys(const Config& config) {
    if (config.api_key_file.empty()) return {State::Good, "no key is needed"};
    const auto ring = KeyRing::read(config.api_key_file);
    return ring ? Found{State::Good, "from " + config.api_key_file} : wrong(ring.error());
}

Found check_signing(const Config& config) {
    if (config.signing.empty()) return {State::Good, "no URL needs a signature"};
    const auto ring = read_signing_keys(config.signing);
    if (!ring) return wrong(ring.error());
    return {State::Good, "from " + (config.signing.file.empty() ? "the environment" : "" + config.signing.file)};
}

/// Checks a folder of files.
/// @param without  description of a server without this folder
Found check_folder(const std::string& path, const char* without) {
    if (path.empty()) return {State::Good, without};
    const auto checked = FileFolder(path, "file").check();
    return checked ? Found{State::Good, "from " + path} : wrong(checked.error());
}

Found check_pictures(const Config& config) {
    return check_folder(config.pictures, "no pictures by name");
}

Found check_docs(const Config& config) {
    return check_folder(config.docs, "no documentation");
}

Found check_memory(const Config& config) {
    const auto memory = memory_to_compute_with(config, resident_bytes());
    if (!memory) return wrong(memory.error());
    return {State::Good, std::to_string(memory->total >> 20) + " MiB of " + std::to_string(config.memory >> 20) +
                             " are left for requests and computations"};
}

Found check_files(const Config& config) {
    allow_open_files(wanted_descriptors(config));
    const auto plan = share_descriptors(config, max_descriptors());
    if (!plan) return wrong(plan.error());
    return {plan->fits() ? State::Good : State::Weak, describe(*plan)};
}

/// Looks for faults of a Redis server. Failures are Weak, because the server starts even without this Redis.
template <class FindFaults>
Found check_redis(const RedisAddress& address, const char* does, FindFaults find_faults) {
    RedisClient client(address);
    const Result<std::vector<std::string>> faults = find_faults(client);
    if (!faults) return {State::Weak, faults.error().message};
    if (faults->empty()) return {State::Good, does + std::string(" Redis at ") + address.name()};
    std::string words;
    for (const auto& fault : *faults) words += (words.empty() ? "" : "; ") + fault;
    return {State::Weak, words};
}

/// Checks that the folder of jobs, or its nearest existing parent folder, is writable.
Found check_jobs(const Config& config) {
    if (config.redis) return check_redis(*config.redis, "stored in", RedisJobStore::find_faults);
    if (config.data_dir.empty()) return {State::Good, "stored in memory, lost when the server ends"};
    std::error_code none;
    auto folder = std::filesystem::absolute(config.data_dir, none);
    while (!std::filesystem::exists(folder, none) && folder.has_relative_path()) folder = folder.parent_path();
    const bool is_folder = std::filesystem::is_directory(folder, none);
    if (is_folder && access(folder.c_str(), W_OK | X_OK) == 0) return {State::Good, "stored in " + config.data_dir};
    return {State::Wrong, folder.string() + ": " + std::strerror(is_folder ? errno : ENOTDIR)};
}

Found check_webhooks(const Config& config) {
    if (config.webhook_hosts.names.empty()) return {State::Good, "none"};
    const auto keys = read_webhook_keys(config.webhook_key_file);
    if (!keys) return wrong(keys.error());
    return {State::Good, "signed with " + config.webhook_key_file};
}

Found check_origins(const Config& config) {
    if (config.origins.names.empty()) return {State::Good, "no pictures by URL"};
    const auto program = find_program("ccdt-fetcher");
    return program ? Found{State::Good, "fetched by " + *program} : wrong(program.error());
}

Found check_answers(const Config& config) {
    if (config.cache_redis) return check_redis(*config.cache_redis, "kept here and in", RedisCache::find_faults);
    return {State::Good, config.cache > 0 ? "kept here" : "not kept"};
}

Found check_rates(const Config& config) {
    if (config.live.rate.per_second <= 0) return {State::Good, "not limited"};
    if (!config.rate_redis) return {State::Good, "counted here"};
    return check_redis(*config.rate_redis, "counted in", [](RedisClient& client) {
        return client.run(RedisCommand{"PING"}).map([](const RedisReply&) { return std::vector<std::string>(); });
    });
}

Found check_address(const Config& config) {
    const auto listener = ListeningSocket::open(config.bind, config.port);
    if (!listener) return wrong(listener.error());
    const bool has_port = listener->port() > 0;
    return {State::Good, config.bind + (has_port ? " port " + std::to_string(listener->port()) : "")};
}

Found check_metrics(const Config& config) {
    if (!config.metrics_port) return {State::Good, "on the same port"};
    const auto listener = ListeningSocket::open(bind_of_metrics(config), *config.metrics_port);
    if (!listener) return wrong(listener.error());
    return {State::Good, bind_of_metrics(config) + " port " + std::to_string(listener->port())};
}

/// The name of a part of the server, and the function that checks the part.
struct Check {
    std::string_view part;
    Found (*run)(const Config&);
};

constexpr Check kChecks[] = {
    {"decoder", check_decoder},   {"worker", check_worker},     {"keys", check_keys},       {"signing", check_signing},
    {"pictures", check_pictures}, {"docs", check_docs},         {"memory", check_memory},   {"files", check_files},
    {"jobs", check_jobs},         {"answers", check_answers},   {"rates", check_rates},     {"address", check_address},
    {"metrics", check_metrics},   {"webhooks", check_webhooks}, {"origins", check_origins},
};

std::string_view name_of(State state) {
    switch (state) {
        case State::Weak:
            return "weak";
        case State::Wrong:
            return "WRONG";
        case State::Good:
            break;
    }
    return "good";
}

std::string padded(std::string_view text) {
    std::string cell(text);
    cell.resize(std::max(cell.size() + 1, kColumn), ' ');
    return cell;
}

}  // namespace

std::vector<Finding> check(const CommandLine& command) {
    std::vector<Finding> findings;
    for (const auto& warning : command.warnings) findings.push_back({"variables", State::Weak, warning});
    for (const auto& [part, run] : kChecks) {
        auto [state, words] = run(command.config);
        findings.push_back({std::string(part), state, std::move(words)});
    }
    return findings;
}

bool would_start(const std::vector<Finding>& findings) {
    return std::ranges::none_of(findings, [](const Finding& finding) { return finding.state == State::Wrong; });
}

std::string describe(const std::vector<Finding>& findings) {
    std::string lines;
    for (const auto& [part, state, words] : findings)
        lines += "  " + padded(part) + padded(name_of(state)) + words + '\n';
    return lines;
}

}  // namespace ccdt::server
