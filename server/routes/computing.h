#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "api/options.h"
#include "server/cache/result_cache.h"
#include "server/config/config.h"
#include "server/http/connection.h"
#include "server/http/http.h"
#include "server/http/problem.h"
#include "server/jobs/jobs.h"
#include "server/work/computation.h"
#include "server/work/memory_budget.h"
#include "server/work/worker_pool.h"

namespace ccdt::server {

/// Answers requests whose answer is computed: while their client waits, or as a job if it would rather not. May be used
/// from any thread.
class Computing {
public:
    /// Pool and jobs must outlive it. Requests may take a third of the memory that the pool has for jobs, besides that.
    Computing(const Config& config, WorkerPool& pool, Compute compute, Jobs& jobs);

    Outcome answer(const Request& request, Connection& connection);

    /// That requests hold until they are done, besides what the pool's jobs take.
    const MemoryBudget& waiting_memory() const { return waiting_memory_; }

    const ResultCache& cache() const { return cache_; }

    /// From now on nothing new is computed.
    void drain() { draining_ = true; }

    /// From now on nothing is waited for: whoever waits for a result is told that the server shuts down.
    void abandon() { abandoned_ = true; }

    /// A refusal that may end well a little later.
    tl::unexpected<Problem> busy(int status, std::string message) const;

private:
    using Clock = std::chrono::steady_clock;
    template <class T>
    using Task = std::function<Result<T>(const Control&, api::Timings&)>;  ///< what a worker does

    struct Asked;
    using AskedPointer = std::shared_ptr<const Asked>;
    struct Product;

    tl::unexpected<Problem> too_slow() const;
    tl::unexpected<Problem> too_large(std::size_t bytes) const;
    tl::expected<std::string, Problem> read_body(const Request& request, Connection& connection, bool deferred) const;
    tl::expected<AskedPointer, Problem> take_in(Question question);
    Outcome defer(const AskedPointer& asked, Connection& connection);
    tl::expected<api::Cost, Problem> find_cost(const AskedPointer& asked, Connection& connection,
                                               Clock::time_point deadline, Stages& stages);
    template <class T>
    tl::expected<T, Problem> have_done(const api::Cost& cost, Task<T> work, Connection& connection,
                                       Clock::time_point deadline, Stages& stages);
    std::string cache_owner(const Connection& connection) const;
    std::optional<Response> recall(const std::string& name, bool compressed, const std::string& owner);
    Outcome compute(const AskedPointer& asked, const std::string& name, bool compressed, Connection& connection);
    tl::expected<Product, Problem> run(const AskedPointer& asked, const api::Cost& cost, bool compressed,
                                       Connection& connection, Clock::time_point deadline, Stages& stages);

    const Config config_;
    WorkerPool& pool_;
    const Compute compute_;
    Jobs& jobs_;
    MemoryBudget waiting_memory_;  ///< of requests; apart, lest those that wait leave nothing to those that run
    ResultCache cache_;
    std::atomic<bool> draining_ = false;
    std::atomic<bool> abandoned_ = false;
};

}  // namespace ccdt::server
