// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/service.h"

#include <chrono>
#include <thread>
#include <utility>

#include "server/config/descriptor_plan.h"
#include "server/files/file_folder.h"
#include "server/jobs/redis_job_store.h"
#include "server/jobs/sqlite_job_store.h"
#include "server/pool/thread_share.h"
#include "server/processes/child_program.h"
#include "server/processes/process.h"

namespace ccdt::server {
namespace {

std::string url_of(const std::string& host, int port) {
    const bool has_colon = host.find(':') != std::string::npos;
    return "http://" + (has_colon ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

Result<std::unique_ptr<DecoderSupervisor>> start_decoder(const Log& log) {
    return DecoderSupervisor::start([](UniqueFd orders) { return spawn_sibling("ccdt-decoder", std::move(orders)); },
                                    [&log](const std::string& message) { log.error(message); });
}

void log_confinement(const Confinement& confinement, const Log& log) {
    if (confinement.is_whole())
        log.info(confinement.describe());
    else if (confinement.has(Layer::Calls))
        log.warning(confinement.describe());
    else
        log.error(confinement.describe());
}

/// Time limit for calls to the Redis of shared answers or rates. It is short, because requests can be answered without
/// this Redis.
constexpr std::chrono::milliseconds kOptionalDeadline{200};

std::unique_ptr<RedisClient> client_of(const std::optional<RedisAddress>& address, std::chrono::milliseconds deadline,
                                       const Log& log) {
    if (!address) return nullptr;
    return std::make_unique<RedisClient>(*address, deadline, [&log](const std::string& damage) { log.error(damage); });
}

Result<std::unique_ptr<AccessControl>> start_access_control(const Config& config, RedisClient* rates) {
    auto access_control = std::make_unique<AccessControl>(config.api_key_file, config.live.rate, rates, config.signing);
    return access_control->read_keys().map([&] { return std::move(access_control); });
}

/// Checks the folders of pictures and of the documentation, if they are configured.
Result<void> check_folders(const Config& config) {
    for (const std::string& path : {config.pictures, config.docs}) {
        if (path.empty()) continue;
        if (auto checked = FileFolder(path, "file").check(); !checked) return checked;
    }
    return {};
}

/// Opens the job store.
/// @param redis  null: jobs are stored in memory or in the data folder
Result<std::unique_ptr<JobStore>> start_store(const Config& config, RedisClient* redis, const Log& log) {
    if (redis != nullptr)
        return make_redis_job_store(
            *redis, config.jobs,
            RedisJobStore::Notes{.info = [&log](const std::string& note) { log.info(note); },
                                 .warning = [&log](const std::string& note) { log.warning(note); },
                                 .error = [&log](const std::string& note) { log.error(note); }});
    auto store = SqliteJobStore::open(config.data_dir, config.jobs);
    if (!store) return tl::unexpected(std::move(store.error()));
    if (const std::uint64_t count = (*store)->damages(); count > 0)
        log.error("the job store is damaged: " + std::to_string(count) +
                  " faults were found, and damaged jobs have failed");
    return *std::move(store);
}

/// Starts to send webhooks, if they are configured.
Result<std::unique_ptr<Webhooks>> start_webhooks(const Config& config, JobStore& store, const Log& log) {
    if (config.webhook_hosts.names.empty()) return nullptr;
    return Webhooks::start({config.webhook_hosts, config.webhook_key_file}, store,
                           [&log](const std::string& what) { log.warning(what); });
}

Result<std::unique_ptr<ComputeSupervisor>> start_computing(const Config& config, DecoderSupervisor& decoder,
                                                           const Log& log) {
    return ComputeSupervisor::start(
        [](UniqueFd socket) { return spawn_sibling("ccdt-worker", std::move(socket)); },
        {.limits = config.limits, .to_yield = WorkerPool::kOverrun, .nice_of_long = WorkerPool::kNiceOfLong},
        [&decoder](const Order& order, const std::stop_token& stop) { decoder.relay(order, stop); },
        [&log](const std::string& what) { log.error(what); });
}

RedisClient::Counts counts_of(const std::unique_ptr<RedisClient>& client) {
    return client ? client->counts() : RedisClient::Counts();
}

/// Raises the limit of open files. If it stays too low, reduces the limits of connections.
Result<Config> with_descriptors(Config config, const Log& log) {
    allow_open_files(wanted_descriptors(config));
    const auto plan = share_descriptors(config, max_descriptors());
    if (!plan) return tl::unexpected(plan.error());
    if (!plan->fits()) log.warning(describe(*plan));
    config.capacity = plan->capacity;
    return config;
}

Compute compute_in(ComputeSupervisor& supervisor) {
    return [&supervisor](const auto& request, const auto& delivery, const auto& control, auto& timings) {
        return supervisor.compute(request, delivery, control, timings);
    };
}

}  // namespace

Result<Service::Parts> Service::start_parts(const Config& config, const Log& log) {
    auto decoder = start_decoder(log);
    if (!decoder) return tl::unexpected(std::move(decoder.error()));
    auto computing = start_computing(config, **decoder, log);
    if (!computing) return tl::unexpected(std::move(computing.error()));
    RedisClients redis{client_of(config.redis, RedisClient::kDeadline, log),
                       client_of(config.cache_redis, kOptionalDeadline, log),
                       client_of(config.rate_redis, kOptionalDeadline, log)};
    auto access_control = start_access_control(config, redis.rates.get());
    if (!access_control) return tl::unexpected(std::move(access_control.error()));
    if (auto checked = check_folders(config); !checked) return tl::unexpected(std::move(checked.error()));
    const auto memory = memory_to_compute_with(config, resident_bytes());
    if (!memory) return tl::unexpected(memory.error());
    auto store = start_store(config, redis.jobs.get(), log);
    if (!store) return tl::unexpected(std::move(store.error()));
    auto webhooks = start_webhooks(config, **store, log);
    if (!webhooks) return tl::unexpected(std::move(webhooks.error()));
    auto listener = ListeningSocket::open(config.bind, config.port);
    if (!listener) return tl::unexpected(std::move(listener.error()));
    std::optional<ListeningSocket> metrics_listener;
    if (config.metrics_port) {
        auto opened = ListeningSocket::open(bind_of_metrics(config), *config.metrics_port);
        if (!opened) return tl::unexpected(std::move(opened.error()));
        metrics_listener.emplace(*std::move(opened));
    }
    return Parts{std::move(redis),           *std::move(decoder),  *std::move(access_control), *memory,
                 *std::move(store),          *std::move(webhooks), *std::move(computing),      *std::move(listener),
                 std::move(metrics_listener)};
}

Result<std::unique_ptr<Service>> Service::start(const Config& config, const Log& log) {
    const auto fitting = with_descriptors(config, log);
    if (!fitting) return tl::unexpected(fitting.error());
    if (const auto limit = address_space_limit())
        log.warning("the address space of a process is limited to " + std::to_string(*limit >> 20) +
                    " MiB (ulimit -v): pictures and large requests may fail with a 500; set --memory instead");
    auto parts = start_parts(*fitting, log);
    if (!parts) return tl::unexpected(std::move(parts.error()));
    std::unique_ptr<Service> service(new Service(*fitting, *std::move(parts), log));
    service->jobs_.start();
    return service;
}

Service::Service(const Config& config, Parts parts, const Log& log)
    : config_(config),
      log_(log),
      parts_(std::move(parts)),
      port_(parts_.listener.port()),
      metrics_port_(parts_.metrics_listener ? parts_.metrics_listener->port() : 0),
      waiting_memory_(parts_.memory.requests),
      pool_(config.workers, config.queue, parts_.memory.jobs),
      metrics_(CCDT_VERSION),
      jobs_(config.jobs, *parts_.store, !config.data_dir.empty() || config.redis, pool_, compute_in(*parts_.computing),
            [this](const JobEnd& end) {
                metrics_.add(end);
                log_.job(end);
                if (parts_.webhooks && !end.job.callback.empty()) parts_.webhooks->wake();
            }),
      routes_(config,
              {.access_control = *parts_.access_control,
               .pool = pool_,
               .waiting_memory = waiting_memory_,
               .compute = compute_in(*parts_.computing),
               .jobs = jobs_,
               .metrics = metrics_,
               .obstacle = [this] { return obstacle(); },
               .warn = [this](const std::string& what) { log_.warning(what); },
               .answers = parts_.redis.answers.get(),
               .read_shapefile = [this](std::string_view archive, const auto& reading, const auto& stop,
                                        auto& timings) { return read_shapefile(archive, reading, stop, timings); }}),
      server_(
          std::move(parts_.listener), config.patience, config.capacity, config.trusted_proxies,
          [this](const auto& request, const auto& received, auto& connection) {
              return routes_.answer(request, received, connection);
          },
          [this](const Exchange& exchange) { record(exchange); },
          [this](const std::string& what) { log_.warning(what); }) {
    if (parts_.metrics_listener)
        metrics_server_.emplace(
            *std::move(parts_.metrics_listener), config.patience, kMetricsCapacity, TrustedProxies(),
            [this](const auto& request, const auto& received, auto& connection) {
                return routes_.answer(request, received, connection, Routes::Port::Metrics);
            },
            [this](const Exchange& exchange) { record(exchange); },
            [this](const std::string& what) { log_.warning(what); });
    metrics_.watch([this] { return figures(); });
    const auto lend = [this](std::size_t running) {
        parts_.computing->lend(threads_for_each(config_.workers, running, config_.threads_per_request));
    };
    lend(0);
    pool_.on_change(lend);
}

Result<void> Service::wait_until_ready(const std::stop_token& stop) const {
    const auto ready = parts_.decoder->wait_until_ready(stop);
    if (!ready) return ready;
    log_confinement(parts_.decoder->confinement(), log_);
    return parts_.computing->wait_until_ready(stop);
}

Result<void> Service::reload(const LiveConfig& live) {
    if (auto read = parts_.access_control->read_keys(); !read) return read;
    if (parts_.webhooks) {
        if (auto read = parts_.webhooks->read_keys(); !read) return read;
    }
    parts_.access_control->set_rate(live.rate);
    routes_.reload(live);
    return {};
}

std::string Service::address() const {
    return is_path(config_.bind) ? config_.bind : url_of(config_.bind, port_);
}

std::string Service::metrics_address() const {
    return metrics_port_ == 0 ? "" : url_of(bind_of_metrics(config_), metrics_port_) + "/metrics";
}

bool Service::serve() {
    std::jthread metrics;
    if (metrics_server_) metrics = std::jthread([this] { metrics_server_->serve(); });
    const bool served = server_.serve();
    if (metrics_server_) metrics_server_->drain();
    return served;
}

void Service::drain() {
    routes_.drain();
    server_.drain();
    jobs_.drain();
}

void Service::record(const Exchange& exchange) {
    metrics_.add(exchange);
    log_.exchange(exchange);
}

/// Returns the reason why the server cannot compute at present; empty if it can.
std::string Service::obstacle() const {
    if (!parts_.decoder->is_ready()) return "the picture decoder is being restarted";
    if (!parts_.decoder->is_responsive()) return "the picture decoder does not answer";
    if (!parts_.computing->is_ready()) return "the fork server of computations is being restarted";
    return parts_.computing->is_responsive() ? "" : "the fork server of computations does not answer";
}

Result<std::string> Service::read_shapefile(std::string_view archive, const api::ShapefileReading& reading,
                                            const std::stop_token& stop, api::Timings& timings) {
    DecoderClient client(
        [this](const Order& order, const std::stop_token& given_up) { return parts_.decoder->relay(order, given_up); });
    auto text = client.read_shapefile(archive, reading, stop);
    timings.processor = std::chrono::duration<double, std::milli>(client.processor_time()).count();
    shapefile_deaths_ += client.deaths();
    return text;
}

/// Collects the metrics that other classes count.
Metrics::Watched Service::figures() const {
    auto computing = parts_.computing->counts();
    computing.decoder_deaths += shapefile_deaths_;
    return {.connections = server_.connections(),
            .memory_budget = parts_.memory.total,
            .memory_reserved = pool_.memory().reserved() + waiting_memory_.reserved(),
            .decoder_restarts = parts_.decoder->restarts(),
            .decoder_silences = parts_.decoder->silences(),
            .computing = computing,
            .lent_threads = parts_.computing->lent(),
            .jobs = jobs_.load(),
            .job_runs = jobs_.counts(),
            .redis = {.jobs = counts_of(parts_.redis.jobs),
                      .answers = counts_of(parts_.redis.answers),
                      .rates = counts_of(parts_.redis.rates)},
            .job_capacity = config_.jobs.bytes,
            .job_damages = parts_.store->damages(),
            .webhooks = parts_.webhooks ? parts_.webhooks->counts() : Webhooks::Counts(),
            .cache = routes_.cache().load()};
}

}  // namespace ccdt::server
