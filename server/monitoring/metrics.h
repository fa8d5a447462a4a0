// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/cache/result_cache.h"
#include "server/compute/compute_supervisor.h"
#include "server/http/capacity.h"
#include "server/http/http_server.h"
#include "server/jobs/job_service.h"
#include "server/pool/worker_pool.h"
#include "server/redis/redis_client.h"
#include "server/webhooks/webhooks.h"

namespace ccdt::server {

/// Counts events for Prometheus, and writes all metrics. Thread-safe.
class Metrics {
public:
    explicit Metrics(std::string_view version);
    ~Metrics();

    Metrics(const Metrics&) = delete;
    Metrics& operator=(const Metrics&) = delete;

    /// Statistics of the calls to Redis, by purpose.
    struct RedisCounts {
        RedisClient::Counts jobs;
        RedisClient::Counts answers;
        RedisClient::Counts rates;
    };

    /// Metrics that other classes count.
    struct Watched {
        Capacity::Counts connections;
        std::size_t memory_budget = 0;    ///< bytes for requests and their computations
        std::size_t memory_reserved = 0;  ///< reserved part of the budget
        std::uint64_t decoder_restarts = 0;
        std::uint64_t decoder_silences = 0;
        ComputeSupervisor::Counts computing;
        std::size_t lent_threads = 0;        ///< number of threads that each computation may use
        std::optional<JobStore::Load> jobs;  ///< none: unknown; the metrics keep their values
        JobService::Counts job_runs;
        RedisCounts redis;
        std::size_t job_capacity = 0;  ///< capacity of the job store in bytes
        std::uint64_t job_damages = 0;
        Webhooks::Counts webhooks;
        ResultCache::Load cache;
    };

    /// Sets the function that returns the `Watched` metrics. Must be called before any thread calls text().
    void watch(std::function<Watched()> figures);

    /// Counts a request that was answered, or whose client closed the connection.
    void add(const Exchange& exchange);

    /// Counts a finished job.
    void add(const JobEnd& end);

    /// Returns all metrics in Prometheus' text format.
    std::string text(const WorkerPool::Load& load) const;

private:
    void add_computed(const Computed& computed, const Stages& stages);

    struct Families;
    const std::unique_ptr<Families> families_;
    std::function<Watched()> watched_ = [] { return Watched{}; };
};

}  // namespace ccdt::server
