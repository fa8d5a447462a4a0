// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/monitoring/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <utility>

#include "server/processes/process.h"

namespace ccdt::server {
namespace {

using prometheus::Counter;
using prometheus::Family;
using prometheus::Gauge;
using prometheus::Histogram;

/// Bucket boundaries of durations in seconds, from a small request to the longest useful time-out.
const Histogram::BucketBoundaries kSeconds = {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25,
                                              0.5,   1,      2.5,   5,    10,    30,   60};

/// Bucket boundaries of thread counts.
const Histogram::BucketBoundaries kThreads = {1, 2, 4, 8, 16, 32, 64};

Gauge& make_gauge(prometheus::Registry& registry, const char* name, const char* help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry).Add({});
}

Counter& make_counter(prometheus::Registry& registry, const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry).Add({});
}

Family<Counter>& make_counters(prometheus::Registry& registry, const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
}

/// Sets a counter to a total that another class has counted. The library can only increment counters.
void raise(Counter& counter, double total) {
    counter.Increment(std::max(0.0, total - counter.Value()));
}

void raise(Counter& counter, std::uint64_t count) {
    raise(counter, static_cast<double>(count));
}

std::string label(std::string_view value) {
    return value.empty() ? "other" : std::string(value);
}

}  // namespace

struct Metrics::Families {
    prometheus::Registry registry;
    Family<Counter>& requests =
        prometheus::BuildCounter()
            .Name("ccdt_http_requests_total")
            .Help("Requests by route and status; 499 means that the client closed the connection.")
            .Register(registry);
    Family<Histogram>& durations = prometheus::BuildHistogram()
                                       .Name("ccdt_http_request_duration_seconds")
                                       .Help("Time from the first byte of a request to the last byte of its answer.")
                                       .Register(registry);
    Family<Histogram>& stages = prometheus::BuildHistogram()
                                    .Name("ccdt_stage_duration_seconds")
                                    .Help("Time of the stages of computed requests.")
                                    .Register(registry);
    Family<Counter>& cancellations = prometheus::BuildCounter()
                                         .Name("ccdt_cancellations_total")
                                         .Help("Cancelled computations, running or queued, by cause.")
                                         .Register(registry);
    Counter& sites = make_counter(registry, "ccdt_sites_total", "Sites of computed answers.");
    Counter& pixels = make_counter(registry, "ccdt_pixels_total", "Pixels of pictures decoded for answers.");
    Counter& received = make_counter(registry, "ccdt_http_received_bytes_total", "Bytes of requests.");
    Counter& sent = make_counter(registry, "ccdt_http_sent_bytes_total", "Bytes of answers.");
    Gauge& connections = make_gauge(registry, "ccdt_connections_open", "Open connections.");
    Gauge& streams = make_gauge(registry, "ccdt_event_streams_open", "Open connections that stream events.");
    Family<Counter>& refusals =
        prometheus::BuildCounter()
            .Name("ccdt_connections_refused_total")
            .Help("Refused connections: a limit of the server, of the address or of streams was reached.")
            .Register(registry);
    Counter& refused_full = refusals.Add({{"reason", "full"}});
    Counter& refused_address = refusals.Add({{"reason", "address"}});
    Counter& refused_streams = refusals.Add({{"reason", "streams"}});
    Gauge& waiting = make_gauge(registry, "ccdt_queue_requests", "Requests waiting for a worker.");
    Gauge& capacity =
        make_gauge(registry, "ccdt_queue_capacity_requests", "Maximum number of requests waiting for a worker.");
    Gauge& oldest = make_gauge(registry, "ccdt_queue_oldest_seconds", "Waiting time of the oldest queued request.");
    Gauge& backlog =
        make_gauge(registry, "ccdt_queue_backlog_seconds", "Estimated time to compute all queued requests.");
    Gauge& workers = make_gauge(registry, "ccdt_workers", "Maximum number of simultaneous computations.");
    Gauge& busy = make_gauge(registry, "ccdt_workers_busy", "Computations running now.");
    Gauge& lent = make_gauge(registry, "ccdt_computation_threads_lent", "Threads that each computation may use now.");
    Histogram& threads = prometheus::BuildHistogram()
                             .Name("ccdt_computation_threads")
                             .Help("Maximum number of simultaneous threads of a computation.")
                             .Register(registry)
                             .Add({}, kThreads);
    Counter& processor =
        make_counter(registry, "ccdt_computation_cpu_seconds_total", "Processor time of computations.");
    Gauge& overdue = make_gauge(registry, "ccdt_workers_overdue_seconds",
                                "Longest time that a worker has continued after a request to stop.");
    Gauge& budget = make_gauge(registry, "ccdt_memory_budget_bytes", "Memory for requests and their computations.");
    Gauge& reserved = make_gauge(registry, "ccdt_memory_reserved_bytes", "Estimated memory that is reserved now.");
    Counter& deaths = make_counter(registry, "ccdt_decoder_deaths_total",
                                   "Pictures and shapefiles whose decoder crashed, exceeded a limit or returned an "
                                   "invalid result.");
    Counter& decoder_restarts =
        make_counter(registry, "ccdt_decoder_restarts_total", "Restarts of the process that starts decoders.");
    Counter& crashes = make_counter(registry, "ccdt_computation_crashes_total",
                                    "Processes that crashed while they computed an answer.");
    Counter& decoder_silences = make_counter(registry, "ccdt_decoder_silences_total",
                                             "Times that the process that starts decoders stopped responding.");
    Counter& silences = make_counter(registry, "ccdt_worker_silences_total",
                                     "Times that the process that starts computation processes stopped responding.");
    Counter& ended_overdue = make_counter(registry, "ccdt_computations_overdue_total",
                                          "Computation processes killed because they did not stop at a deadline.");
    Counter& restarts = make_counter(registry, "ccdt_worker_restarts_total",
                                     "Restarts of the process that starts computation processes.");
    Family<Gauge>& jobs =
        prometheus::BuildGauge().Name("ccdt_jobs").Help("Unfinished jobs, by status.").Register(registry);
    Gauge& jobs_queued = jobs.Add({{"status", "queued"}});
    Gauge& jobs_running = jobs.Add({{"status", "running"}});
    Family<Counter>& jobs_ended =
        prometheus::BuildCounter().Name("ccdt_jobs_ended_total").Help("Finished jobs, by status.").Register(registry);
    Gauge& job_bytes = make_gauge(registry, "ccdt_job_store_bytes", "Storage used by jobs: requests and results.");
    Gauge& job_capacity = make_gauge(registry, "ccdt_job_store_capacity_bytes", "Storage available to jobs.");
    Counter& job_damages = make_counter(registry, "ccdt_job_store_damages_total",
                                        "Jobs, requests and results found damaged in the store.");
    Counter& webhooks_sent = make_counter(registry, "ccdt_webhooks_sent_total", "Webhooks that their hosts accepted.");
    Counter& webhooks_failed =
        make_counter(registry, "ccdt_webhook_failures_total", "Failed attempts to send a webhook.");
    Counter& leases_lost = make_counter(registry, "ccdt_job_leases_lost_total",
                                        "Runs abandoned because another server had claimed the job.");
    Counter& runs_repeated =
        make_counter(registry, "ccdt_job_runs_repeated_total", "Runs of jobs that an earlier run had not finished.");
    Family<Counter>& redis_calls = make_counters(registry, "ccdt_redis_calls_total", "Calls to Redis.");
    Family<Counter>& redis_failures = make_counters(registry, "ccdt_redis_failures_total", "Failed calls to Redis.");
    Family<Counter>& redis_seconds =
        make_counters(registry, "ccdt_redis_seconds_total", "Time spent waiting for Redis.");
    Counter& cache_hits = make_counter(registry, "ccdt_cache_hits_total", "Answers found in the cache.");
    Counter& cache_misses = make_counter(registry, "ccdt_cache_misses_total", "Answers not found in the cache.");
    Gauge& cache_bytes = make_gauge(registry, "ccdt_cache_bytes", "Size of the cached answers.");
    Gauge& memory = make_gauge(registry, "process_resident_memory_bytes", "Resident memory.");
    Gauge& descriptors = make_gauge(registry, "process_open_fds", "Open file descriptors.");
    Gauge& max_descriptors = make_gauge(registry, "process_max_fds", "Maximum number of open file descriptors.");

    std::mutex mutex;  ///< held while raise() updates counters

    void raise_redis(const char* use, const RedisClient::Counts& counts) {
        raise(redis_calls.Add({{"use", use}}), counts.calls);
        raise(redis_failures.Add({{"use", use}}), counts.failures);
        raise(redis_seconds.Add({{"use", use}}), counts.seconds);
    }

    Histogram& stage(const char* name) { return stages.Add({{"stage", name}}, kSeconds); }
};

Metrics::Metrics(std::string_view version) : families_(std::make_unique<Families>()) {
    Families& all = *families_;
    prometheus::BuildGauge()
        .Name("ccdt_build_info")
        .Help("The program's version; always 1.")
        .Register(all.registry)
        .Add({{"version", std::string(version)}})
        .Set(1);
    const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
    make_gauge(all.registry, "process_start_time_seconds", "Start time of the process, in seconds since 1970.")
        .Set(now.count());
    // Creates the counters at the start, so that the rate of an event that has not occurred is 0 rather than missing.
    for (const char* cause : {"client_gone", "deadline", "shutdown"}) all.cancellations.Add({{"cause", cause}});
    for (const char* status : {"succeeded", "failed", "cancelled"}) all.jobs_ended.Add({{"status", status}});
    for (const char* stage : {"queue", "decode", "prepare", "optimise", "encode"}) all.stage(stage);
}

Metrics::~Metrics() = default;

void Metrics::add(const Exchange& exchange) {
    constexpr double kMilliseconds = 1e-3;
    Families& all = *families_;
    const Record& record = exchange.response.record;
    const std::string route = label(record.route);
    all.requests.Add({{"route", route}, {"status", std::to_string(exchange.response.status)}}).Increment();
    all.durations.Add({{"route", route}}, kSeconds).Observe(exchange.milliseconds * kMilliseconds);
    all.received.Increment(static_cast<double>(exchange.bytes_in));
    all.sent.Increment(static_cast<double>(exchange.bytes_out));
    if (!record.cancelled.empty()) all.cancellations.Add({{"cause", std::string(record.cancelled)}}).Increment();
    if (record.computed) add_computed(*record.computed, record.stages);
}

void Metrics::add(const JobEnd& end) {
    families_->jobs_ended.Add({{"status", std::string(name_of(end.job.status))}}).Increment();
    if (end.computed) add_computed(*end.computed, end.stages);
}

void Metrics::add_computed(const Computed& computed, const Stages& stages) {
    constexpr double kMilliseconds = 1e-3;
    Families& all = *families_;
    const auto& [queue, work] = stages;
    for (const auto& [name, spent] :
         {std::pair{"queue", queue}, std::pair{"decode", work.decode}, std::pair{"prepare", work.prepare},
          std::pair{"optimise", work.optimise}, std::pair{"encode", work.encode}})
        all.stage(name).Observe(spent * kMilliseconds);
    all.threads.Observe(static_cast<double>(work.threads));
    all.processor.Increment(work.processor * kMilliseconds);
    all.sites.Increment(static_cast<double>(computed.sites));
    all.pixels.Increment(static_cast<double>(computed.pixels));
}

void Metrics::watch(std::function<Watched()> figures) {
    watched_ = std::move(figures);
}

std::string Metrics::text(const WorkerPool::Load& load) const {
    Families& all = *families_;
    const Watched watched = watched_();
    all.connections.Set(static_cast<double>(watched.connections.open));
    all.streams.Set(static_cast<double>(watched.connections.streams));
    all.budget.Set(static_cast<double>(watched.memory_budget));
    all.reserved.Set(static_cast<double>(watched.memory_reserved));
    {
        const std::lock_guard lock(all.mutex);
        raise(all.refused_full, watched.connections.refused);
        raise(all.refused_address, watched.connections.refused_by_address);
        raise(all.refused_streams, watched.connections.refused_streams);
        raise(all.deaths, watched.computing.decoder_deaths);
        raise(all.decoder_restarts, watched.decoder_restarts);
        raise(all.decoder_silences, watched.decoder_silences);
        raise(all.job_damages, watched.job_damages);
        raise(all.webhooks_sent, watched.webhooks.sent);
        raise(all.webhooks_failed, watched.webhooks.failed);
        raise(all.leases_lost, watched.job_runs.lost);
        raise(all.runs_repeated, watched.job_runs.repeated);
        all.raise_redis("jobs", watched.redis.jobs);
        all.raise_redis("answers", watched.redis.answers);
        all.raise_redis("rates", watched.redis.rates);
        raise(all.crashes, watched.computing.crashes);
        raise(all.ended_overdue, watched.computing.overdue);
        raise(all.restarts, watched.computing.restarts);
        raise(all.silences, watched.computing.silences);
        raise(all.cache_hits, watched.cache.hits);
        raise(all.cache_misses, watched.cache.misses);
    }
    if (watched.jobs) {
        all.jobs_queued.Set(static_cast<double>(watched.jobs->queued));
        all.jobs_running.Set(static_cast<double>(watched.jobs->running));
        all.job_bytes.Set(static_cast<double>(watched.jobs->bytes));
    }
    all.job_capacity.Set(static_cast<double>(watched.job_capacity));
    all.cache_bytes.Set(static_cast<double>(watched.cache.bytes));
    all.waiting.Set(static_cast<double>(load.waiting));
    all.capacity.Set(static_cast<double>(load.capacity));
    all.oldest.Set(load.oldest_seconds);
    all.backlog.Set(load.backlog_seconds);
    all.workers.Set(static_cast<double>(load.workers));
    all.busy.Set(static_cast<double>(load.busy));
    all.lent.Set(static_cast<double>(watched.lent_threads));
    all.overdue.Set(load.overdue_seconds);
    all.memory.Set(static_cast<double>(resident_bytes()));
    all.descriptors.Set(static_cast<double>(open_descriptors()));
    all.max_descriptors.Set(static_cast<double>(max_descriptors()));
    return prometheus::TextSerializer().Serialize(all.registry.Collect());
}

}  // namespace ccdt::server
