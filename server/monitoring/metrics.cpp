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

/// Bounds of durations: from a small request's to the longest timeout that makes sense.
const Histogram::BucketBoundaries kSeconds = {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25,
                                              0.5,   1,      2.5,   5,    10,    30,   60};

/// Bounds of numbers of threads.
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

/// Raises a counter to what is counted elsewhere; counters know no other way than up.
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
    Family<Counter>& requests = prometheus::BuildCounter()
                                    .Name("ccdt_http_requests_total")
                                    .Help("Requests by route and status; 499 is a client that went away.")
                                    .Register(registry);
    Family<Histogram>& durations = prometheus::BuildHistogram()
                                       .Name("ccdt_http_request_duration_seconds")
                                       .Help("From a request's first byte to its answer's last.")
                                       .Register(registry);
    Family<Histogram>& stages = prometheus::BuildHistogram()
                                    .Name("ccdt_stage_duration_seconds")
                                    .Help("Where the time of computed requests goes.")
                                    .Register(registry);
    Family<Counter>& cancellations = prometheus::BuildCounter()
                                         .Name("ccdt_cancellations_total")
                                         .Help("Computations and waits that were given up, by cause.")
                                         .Register(registry);
    Counter& sites = make_counter(registry, "ccdt_sites_total", "Sites of the answers computed.");
    Counter& pixels = make_counter(registry, "ccdt_pixels_total", "Pixels of the pictures decoded for answers.");
    Counter& received = make_counter(registry, "ccdt_http_received_bytes_total", "Bytes of requests.");
    Counter& sent = make_counter(registry, "ccdt_http_sent_bytes_total", "Bytes of answers.");
    Gauge& connections = make_gauge(registry, "ccdt_connections_open", "Open connections.");
    Gauge& streams = make_gauge(registry, "ccdt_event_streams_open", "Those of them that stream events.");
    Family<Counter>& refusals =
        prometheus::BuildCounter()
            .Name("ccdt_connections_refused_total")
            .Help("Connections that were refused: the server, their address or the streams had enough.")
            .Register(registry);
    Counter& refused_full = refusals.Add({{"reason", "full"}});
    Counter& refused_address = refusals.Add({{"reason", "address"}});
    Counter& refused_streams = refusals.Add({{"reason", "streams"}});
    Gauge& waiting = make_gauge(registry, "ccdt_queue_requests", "Requests that wait for a worker.");
    Gauge& capacity = make_gauge(registry, "ccdt_queue_capacity_requests", "Requests that may wait for a worker.");
    Gauge& oldest = make_gauge(registry, "ccdt_queue_oldest_seconds", "How long the oldest of them has waited.");
    Gauge& backlog = make_gauge(registry, "ccdt_queue_backlog_seconds", "How long they will keep the workers busy.");
    Gauge& workers = make_gauge(registry, "ccdt_workers", "Computations that there may be at once.");
    Gauge& busy = make_gauge(registry, "ccdt_workers_busy", "Computations that there are now.");
    Gauge& lent = make_gauge(registry, "ccdt_computation_threads_lent", "Threads that each of them may have now.");
    Histogram& threads = prometheus::BuildHistogram()
                             .Name("ccdt_computation_threads")
                             .Help("Threads that have worked on an answer at once, at most.")
                             .Register(registry)
                             .Add({}, kThreads);
    Counter& processor =
        make_counter(registry, "ccdt_computation_cpu_seconds_total", "Processor time of computing answers.");
    Gauge& overdue = make_gauge(registry, "ccdt_workers_overdue_seconds",
                                "How long the slowest worker has gone on after it was told to stop.");
    Gauge& budget = make_gauge(registry, "ccdt_memory_budget_bytes", "For requests and what is computed for them.");
    Gauge& reserved = make_gauge(registry, "ccdt_memory_reserved_bytes", "Of the budget, by estimate, taken now.");
    Counter& deaths = make_counter(registry, "ccdt_decoder_deaths_total",
                                   "Pictures and shapefiles whose decoder crashed, passed a limit or gave nonsense.");
    Counter& decoder_restarts =
        make_counter(registry, "ccdt_decoder_restarts_total",
                     "Times that the process which starts decoders ended and was started again.");
    Counter& crashes =
        make_counter(registry, "ccdt_computation_crashes_total", "Processes that ended while they computed an answer.");
    Counter& decoder_silences = make_counter(registry, "ccdt_decoder_silences_total",
                                             "Times that the process that starts decoders stopped answering.");
    Counter& silences = make_counter(registry, "ccdt_worker_silences_total",
                                     "Times that the process that starts those that compute stopped answering.");
    Counter& ended_overdue = make_counter(registry, "ccdt_computations_overdue_total",
                                          "Processes that were ended because they did not stop at a deadline.");
    Counter& restarts = make_counter(registry, "ccdt_worker_restarts_total",
                                     "Times that what makes these processes ended and was started again.");
    Family<Gauge>& jobs =
        prometheus::BuildGauge().Name("ccdt_jobs").Help("Jobs that have not ended, by status.").Register(registry);
    Gauge& jobs_queued = jobs.Add({{"status", "queued"}});
    Gauge& jobs_running = jobs.Add({{"status", "running"}});
    Family<Counter>& jobs_ended =
        prometheus::BuildCounter().Name("ccdt_jobs_ended_total").Help("Jobs that ended, by how.").Register(registry);
    Gauge& job_bytes = make_gauge(registry, "ccdt_job_store_bytes", "What is kept of jobs: questions and results.");
    Gauge& job_capacity = make_gauge(registry, "ccdt_job_store_capacity_bytes", "What may be kept of jobs.");
    Counter& job_damages = make_counter(registry, "ccdt_job_store_damages_total",
                                        "Jobs, their requests and results that the disk had changed.");
    Counter& leases_lost = make_counter(registry, "ccdt_job_leases_lost_total",
                                        "Runs given up, for others had claimed their jobs meanwhile.");
    Counter& runs_repeated = make_counter(registry, "ccdt_job_runs_repeated_total",
                                          "Runs of jobs that a run before had not brought to an end.");
    Family<Counter>& redis_calls = make_counters(registry, "ccdt_redis_calls_total", "Times that Redis was asked.");
    Family<Counter>& redis_failures =
        make_counters(registry, "ccdt_redis_failures_total", "Times that Redis did not do what it was asked.");
    Family<Counter>& redis_seconds =
        make_counters(registry, "ccdt_redis_seconds_total", "Time that Redis was waited for.");
    Counter& cache_hits = make_counter(registry, "ccdt_cache_hits_total", "Answers given again.");
    Counter& cache_misses = make_counter(registry, "ccdt_cache_misses_total", "Answers looked for in vain.");
    Gauge& cache_bytes = make_gauge(registry, "ccdt_cache_bytes", "Of answers that are kept.");
    Gauge& memory = make_gauge(registry, "process_resident_memory_bytes", "Resident memory.");
    Gauge& descriptors = make_gauge(registry, "process_open_fds", "Open file descriptors.");
    Gauge& most_descriptors = make_gauge(registry, "process_max_fds", "File descriptors that may be open.");

    std::mutex mutex;  ///< guards the rise of what is counted elsewhere

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
    make_gauge(all.registry, "process_start_time_seconds", "When the process started, in seconds since 1970.")
        .Set(now.count());
    // There from the start: a rate over what has not happened yet is 0, and not missing.
    for (const char* cause : {"client_gone", "deadline", "shutdown"}) all.cancellations.Add({{"cause", cause}});
    for (const char* status : {"succeeded", "failed", "cancelled"}) all.jobs_ended.Add({{"status", status}});
    for (const char* stage : {"queue", "decode", "optimise", "encode"}) all.stage(stage);
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
    for (const auto& [name, spent] : {std::pair{"queue", queue}, std::pair{"decode", work.decode},
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
    all.most_descriptors.Set(static_cast<double>(most_descriptors()));
    return prometheus::TextSerializer().Serialize(all.registry.Collect());
}

}  // namespace ccdt::server
