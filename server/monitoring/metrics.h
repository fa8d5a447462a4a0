#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/cache/result_cache.h"
#include "server/compute/compute_box.h"
#include "server/http/capacity.h"
#include "server/http/http_server.h"
#include "server/jobs/jobs.h"
#include "server/redis/redis_client.h"
#include "server/work/worker_pool.h"

namespace ccdt::server {

/// Figures about the service for Prometheus. May be used from any thread.
class Metrics {
public:
    explicit Metrics(std::string_view version);
    ~Metrics();

    Metrics(const Metrics&) = delete;
    Metrics& operator=(const Metrics&) = delete;

    /// What Redis was asked for.
    struct RedisCounts {
        RedisClient::Counts jobs;
        RedisClient::Counts answers;
        RedisClient::Counts rates;
    };

    /// Figures that are counted elsewhere.
    struct Watched {
        Capacity::Counts connections;
        std::size_t memory_budget = 0;    ///< bytes for requests and what is computed for them
        std::size_t memory_reserved = 0;  ///< of them
        std::uint64_t decoder_restarts = 0;
        std::uint64_t decoder_silences = 0;
        ComputeBox::Counts computing;
        std::size_t lent_threads = 0;        ///< that each computation may have now
        std::optional<JobStore::Load> jobs;  ///< none: they stay as they were
        Jobs::Counts job_runs;
        RedisCounts redis;
        std::size_t job_capacity = 0;  ///< bytes that may be kept
        std::uint64_t job_damages = 0;
        ResultCache::Load cache;
    };

    /// Has these figures taken from there. To be called before any thread asks for figures.
    void watch(std::function<Watched()> figures);

    /// Counts a request that was answered, or whose client left.
    void add(const Exchange& exchange);

    /// Counts a job that has ended.
    void add(const JobEnd& end);

    /// Writes all figures in Prometheus' text format, the pool's as they are now.
    std::string text(const WorkerPool::Load& load) const;

private:
    void add_computed(const Computed& computed, const Stages& stages);

    struct Families;
    const std::unique_ptr<Families> families_;
    std::function<Watched()> watched_ = [] { return Watched{}; };
};

}  // namespace ccdt::server
