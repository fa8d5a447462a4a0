// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "api/run/options.h"
#include "server/cache/result_cache.h"
#include "server/config/config.h"
#include "server/files/file_folder.h"
#include "server/http/message.h"
#include "server/http/problem.h"
#include "server/jobs/job_service.h"
#include "server/pool/memory_budget.h"
#include "server/pool/worker_pool.h"
#include "server/requests/compute.h"
#include "server/requests/operation.h"
#include "server/requests/shapefile_request.h"
#include "server/routes/incoming.h"

namespace ccdt::server {

/// Answers requests that need a computation: while the client waits or, if the client prefers, as a job. Thread-safe.
class ComputeRoutes {
public:
    /// @param waiting_memory  budget for requests until they are answered; the pool's budget is separate
    /// @param answers         Redis in which servers share answers; null: none
    /// `pool`, `waiting_memory`, `jobs` and `answers` must outlive this object.
    ComputeRoutes(const Config& config, WorkerPool& pool, MemoryBudget& waiting_memory, Compute compute,
                  ReadShapefile read_shapefile, JobService& jobs, RedisClient* answers);

    HttpResult<Response> answer(const Operation& operation, const Presets& presets, const Incoming& incoming);

    /// Answers a request for a picture of the server. The answer is the same as for a request with this picture as the
    /// body and `options` as the query.
    HttpResult<Response> answer(const Operation& operation, const Presets& presets, OpenFile picture,
                                std::string options, const Incoming& incoming);

    const ResultCache& cache() const { return cache_; }

    /// Begins the shutdown: from now on, computes an answer only for the first request of each connection, and refuses
    /// later ones.
    void drain() { draining_ = true; }

    /// Tells all waiting clients, also those of later requests, that the server is shutting down.
    void abandon() { abandoned_ = true; }

    /// Makes a problem whose Retry-After is the estimated time until the waiting requests are computed.
    tl::unexpected<Problem> busy(int status, std::string message) const;

private:
    using Clock = std::chrono::steady_clock;
    struct AcceptedRequest;
    using AcceptedPointer = std::shared_ptr<const AcceptedRequest>;
    struct ComputedAnswer;
    template <class T>
    class PendingResult;
    class TeeWriter;

    /// Estimates of the cost of a request and the size of its answer, and whether it accepts a partial answer.
    struct Forecast {
        api::Cost cost;
        std::size_t largest_answer = 0;
        bool accepts_partial = false;
    };

    /// Whether a task can be stopped, so that the pool may displace it.
    enum class Stoppable { Yes, No };

    /// Limits of the wait for a result.
    struct TimeLimit {
        Clock::time_point deadline;                 ///< time at which the computation is told to stop
        Clock::duration grace = Clock::duration();  ///< extra time for the stopped computation to return a result
    };

    /// A task for a worker. If it sets the PendingResult before it returns, the returned result is ignored.
    template <class T>
    using Task = std::function<Result<T>(const Control&, api::Timings&, PendingResult<T>&)>;

    tl::unexpected<Problem> too_slow(Record& record) const;
    tl::unexpected<Problem> too_large(std::size_t bytes) const;
    HttpResult<void> check_drain(const Incoming& incoming) const;
    HttpResult<std::string> read_body(const Incoming& incoming, const std::optional<std::string>& url, bool deferred);
    HttpResult<std::string> fetch_picture(const std::string& url, const Incoming& incoming);
    HttpResult<MemoryBudget::Lease> reserve_memory(std::size_t size);
    HttpResult<AcceptedPointer> prepare(const Operation& operation, ComputeRequest request,
                                        const std::vector<FormPart>& fields, MemoryBudget::Lease lease);
    HttpResult<Response> respond(const AcceptedPointer& accepted, const Incoming& incoming);
    HttpResult<std::string> find_callback(const Request& request) const;
    HttpResult<Response> defer(const AcceptedPointer& accepted, const std::string& callback, const Incoming& incoming);
    HttpResult<AcceptedPointer> convert_shapefile(const AcceptedPointer& accepted, const Incoming& incoming,
                                                  Clock::time_point deadline);
    HttpResult<Forecast> forecast(const AcceptedPointer& accepted, const Incoming& incoming,
                                  Clock::time_point deadline);
    template <class T>
    HttpResult<T> run_in_worker(Task<T> task, api::Cost cost, const Incoming& incoming, const TimeLimit& limit,
                                Stoppable stoppable = Stoppable::Yes);
    template <class T>
    HttpResult<void> wait_for(PendingResult<T>& pending, WorkerPool::JobId job, const Incoming& incoming,
                              const TimeLimit& limit);
    std::string cache_owner(const Connection& connection) const;
    Stream stream_of(const ComputedAnswer& computed, std::string doubt, const Incoming& incoming,
                     Clock::time_point latest) const;
    std::optional<Response> find_cached(const std::string& name, bool compressed, const Incoming& incoming);
    HttpResult<Response> compute(const AcceptedPointer& accepted, bool compressed, const Incoming& incoming);
    HttpResult<ComputedAnswer> run(const AcceptedPointer& accepted, const api::Cost& cost, bool compressed,
                                   const Incoming& incoming, const TimeLimit& limit);

    const Config config_;
    WorkerPool& pool_;
    MemoryBudget& waiting_memory_;
    const Compute compute_;
    const ReadShapefile read_shapefile_;
    JobService& jobs_;
    ResultCache cache_;
    /// Number of pictures that are being fetched, and of look-ups that have not ended. These may outlive this object.
    const std::shared_ptr<std::atomic<int>> fetches_ = std::make_shared<std::atomic<int>>(0);
    std::atomic<bool> draining_ = false;
    std::atomic<bool> abandoned_ = false;
};

}  // namespace ccdt::server
