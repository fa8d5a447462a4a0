#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/http/http.h"
#include "server/http/problem.h"
#include "server/jobs/job.h"
#include "server/jobs/job_limits.h"
#include "server/jobs/job_store.h"
#include "server/work/computation.h"
#include "server/work/worker_pool.h"

namespace ccdt::server {

/// A job that has ended, for log and figures.
struct JobEnd {
    Job job;
    Stages stages;
    std::optional<Computed> computed;
    std::string cause;  ///< of a failure of ours
};

/// Runs jobs: requests whose clients do not wait.
///
/// What was accepted is in the store, and ends in a result, a failure or a cancellation that is in the store as well. A
/// job waits there, where clients take turns, and is claimed and handed to the pool when its turn has come and there is
/// a place for it. In the pool it competes with the requests that are waited for; jobs have at most all workers but
/// one, and at least one. Where servers share a store, each runs what it has claimed, and answers about all jobs.
///
/// A job has `timeout` from the start of its run, and is forgotten `ttl` after its end. May be used from any thread.
class Jobs : private JobListener {
    struct Followed;

public:
    using Clock = std::chrono::steady_clock;
    using Logger = std::function<void(const JobEnd&)>;

    /// What has happened to runs of this server.
    struct Counts {
        std::uint64_t lost = 0;      ///< given up, for others had claimed their jobs meanwhile
        std::uint64_t repeated = 0;  ///< of jobs that another run had not brought to an end
    };

    /// @param survives  the store outlives the process: what is not done when it drains is done by the next one
    /// The others must outlive it. No other may listen to the store.
    Jobs(const JobLimits& limits, JobStore& store, bool survives, WorkerPool& pool, Compute compute, Logger logger);

    /// Stops what runs.
    ~Jobs() override;

    Jobs(const Jobs&) = delete;
    Jobs& operator=(const Jobs&) = delete;

    /// Begins to run jobs, first those that the store has from before.
    void start();

    /// Whether a job that the client submits now would be refused.
    bool is_full(std::string_view client) const;

    /// Takes on a job; once this returns it will not be lost.
    ///
    /// @param job  whose it is, and what it costs, which the pool has room for
    /// Problems: 413 larger than the store, or its result is, 429 the queue is full, or the store of what waits, 503
    /// the server shuts down, 507 and 500 the store fails.
    HttpResult<Job> accept(Job job, const ComputeRequest& request);

    /// Finds a job. Problems, of the following too: 404 there is no such job, or it is somebody else's; 503 the store
    /// cannot be reached, 500 it fails.
    HttpResult<Job> find(const std::string& id, const std::string& owner) const;

    /// The result of a job that has succeeded. Problems: 410 it was dropped to make room, or the job is gone.
    HttpResult<std::string> result(const std::string& id);

    /// A piece of it: see JobStore::piece. Problems: as of result().
    HttpResult<std::string> piece(const std::string& id, std::size_t number);

    /// Cancels a job that has not finished, and forgets one that has.
    HttpResult<void> remove(const std::string& id, const std::string& owner);

    /// Follows a job.
    class Watch {
    public:
        /// Waits for news: first where the job stands, then each iteration, in the end how it ended. Of a job that
        /// another server runs some iterations may be passed over.
        /// @returns  none if there was none until then
        std::optional<Job> next(Clock::time_point until);

        /// Has the next call ask the store, which may have lost the job without a word.
        void look_again();

        /// Whether there will be no more news: it was told how the job ended, or the job is gone.
        bool is_over() const { return over_; }

    private:
        friend class Jobs;
        Watch(const Jobs& jobs, std::shared_ptr<Followed> job) : jobs_(jobs), job_(std::move(job)) {}

        const Jobs& jobs_;
        const std::shared_ptr<Followed> job_;
        std::optional<std::size_t> seen_;  ///< iterations
        bool over_ = false;
    };
    HttpResult<Watch> watch(const std::string& id, const std::string& owner) const;

    /// Accepts no more and stops what runs; returns at once. If the store survives, what is not done is for the next
    /// server, or for others; else it fails.
    void drain();
    bool is_draining() const;

    /// Jobs of all servers that share the store; none where it cannot be reached.
    std::optional<JobStore::Load> load() const;
    Counts counts() const;

private:
    /// Reasons to stop a run.
    enum class Stop { None, Deadline, Shutdown, Gone };

    /// How a job ends, to be stored.
    struct End {
        std::string result;
        JobEnd told;
        JobStore::Taken before = {};  ///< what the store has of the result, which comes before that
    };
    class ResultWriter;

    /// A job that this server has claimed.
    struct Run {
        Job job;
        std::optional<WorkerPool::JobId> handed;  ///< to the pool
        std::optional<Clock::time_point> deadline;
        Stop stop = Stop::None;
        std::stop_source gone;    ///< stopped once nobody wants the result
        Clock::time_point held;   ///< the last time that its lease was renewed, or that was tried
        bool told = true;         ///< the store knows where it stands
        bool settling = false;    ///< whoever has set it stores how the job ends; nobody else does
        std::optional<End> left;  ///< could not be stored yet
    };
    using RunPointer = std::shared_ptr<Run>;

    /// A job that somebody follows.
    struct Followed {
        Job job;
        std::vector<JobProgress> steps;
        bool stale = false;  ///< the store may know better
        bool gone = false;
        std::condition_variable changed;
    };
    using FollowedPointer = std::shared_ptr<Followed>;

    void work() override;
    void changed(const std::string& id) override;
    void stop(const std::string& id) override;
    void missed() override;

    HttpResult<void> add(Job& job, const ComputeRequest& request);
    void hand_out(const std::stop_token& closing);
    bool hand_one();
    void hand(Job job);
    void run(const RunPointer& run, const std::stop_token& stop);
    bool begin(const RunPointer& run);
    std::optional<End> compute(const RunPointer& run, const std::stop_token& stop);
    End end_of(Job job, Result<api::Answer> answer, ResultWriter& writer, const Stages& stages) const;
    void note(const RunPointer& run, const Progress& progress);
    void give_back(const RunPointer& run);
    void settle(const RunPointer& run, End end);
    Result<std::optional<Time>> store_end(End& end);
    void fail_all();

    bool stop_locked(Run& run, Stop why);
    bool keep_locked(const RunPointer& run, JobStore::Owned owned);
    void drop_locked(const RunPointer& run);
    void forget_locked(const RunPointer& run);
    void release_locked();
    std::size_t count_left_locked() const;

    void add_latest(Job& job) const;
    FollowedPointer find_followed_locked(const std::string& id) const;
    static void advance_locked(Followed& followed, const Job& job);
    void changed_locked(const std::string& id);
    void publish_locked(const Job& job);
    void look_again(const std::string& id, Followed& followed) const;

    void keep_time(const std::stop_token& closing);
    Clock::time_point stop_overdue_locked();
    Clock::time_point next_renewal_locked(const Run& run) const;
    Clock::time_point next_renewal_locked() const;
    void renew_leases();
    void settle_what_is_left();

    const JobLimits limits_;
    JobStore& store_;
    const bool survives_;
    WorkerPool& pool_;
    const Compute compute_;
    const Logger logger_;
    const std::size_t at_once_;  ///< jobs that the pool is handed

    mutable std::mutex mutex_;  ///< guards the members from here to `draining_`; not held where the store is used
    std::condition_variable idle_;
    std::condition_variable_any wake_claimer_;
    std::condition_variable_any wake_timekeeper_;
    bool has_work_ = false;  ///< for the claimer
    bool news_ = false;      ///< for the timekeeper
    std::map<std::string, RunPointer> runs_;
    mutable std::map<std::string, std::weak_ptr<Followed>> followed_;
    std::size_t handed_ = 0;  ///< to the pool, and not done
    Counts counts_;
    bool started_ = false;
    bool draining_ = false;

    std::jthread claimer_;     ///< claims jobs; with the next one last: they use all the rest
    std::jthread timekeeper_;  ///< stops runs at their deadlines, renews leases, forgets jobs
};

}  // namespace ccdt::server
