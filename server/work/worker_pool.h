#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "api/run/options.h"
#include "server/work/fair_queue.h"
#include "server/work/memory_budget.h"

namespace ccdt::server {

/// A fixed number of threads that do all computing, behind queues that can say no.
///
/// Clients take turns by what their jobs are expected to cost, and a client without a waiting job is let in even where
/// others have filled the queue, until it is twice as long. So a hundred jobs of one client keep another's only one
/// waiting no longer than those that run. Short jobs do not even wait for those: they have a queue of their own, and
/// one thread more that does nothing else.
///
/// A job begins only when the memory it is expected to take is there. Those of its queue that are behind it wait, too,
/// lest it never be.
///
/// All members may be called from any thread, jobs included.
class WorkerPool {
public:
    /// Whoever submits a job keeps its result; a job that throws is dropped.
    using Job = std::function<void(std::stop_token)>;
    using JobId = std::uint64_t;
    using Clock = std::chrono::steady_clock;

    /// State that a job was in when it was cancelled.
    enum class Cancelled { Queued, Running, Unknown };

    struct Load {
        std::size_t workers = 0;
        std::size_t busy = 0;        ///< threads: one more than workers at most
        std::size_t waiting = 0;     ///< jobs
        std::size_t capacity = 0;    ///< jobs that may wait
        double oldest_seconds = 0;   ///< that a job has waited
        double backlog_seconds = 0;  ///< until those that wait are done, at the pace of late
        double overdue_seconds = 0;  ///< that a job has gone on after it was cancelled
    };

    /// Seconds that a short job is expected to take at most.
    static constexpr double kShort = 0.02;

    /// @param workers   >= 1
    /// @param capacity  jobs, short ones or others, that may wait while all workers are busy
    /// @param memory    bytes that jobs may take at the same time
    WorkerPool(std::size_t workers, std::size_t capacity, std::size_t memory = std::numeric_limits<std::size_t>::max());

    /// Tells running jobs to stop and drops those that wait; `drain` first to have all of them done.
    ~WorkerPool();

    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// @param client  whose turn it takes; any name
    /// @param cost    expected; memory at most what jobs may take
    /// @returns       none: the queue is full
    std::optional<JobId> submit(const std::string& client, Job job, const api::Cost& cost = {0, 1});

    /// Submits a job that has room whatever waits: the number of such jobs is bounded elsewhere.
    JobId submit_always(const std::string& client, Job job, const api::Cost& cost);

    /// Forgets a waiting job, and stops a running one by its token; does nothing for any other id.
    Cancelled cancel(JobId id);

    /// Whether a job that the client submits now would be refused, whatever it costs or, if so much is known, one that
    /// is not short.
    bool is_full(std::string_view client, bool may_be_short = true) const;

    /// Has it told how many jobs run whenever that changes, at once and not for long. To be called before any are
    /// submitted.
    void on_change(std::function<void(std::size_t running)> tell) { tell_ = std::move(tell); }

    /// Memory, of which running jobs take their part.
    MemoryBudget& memory() { return memory_; }
    const MemoryBudget& memory() const { return memory_; }

    /// Returns once every job that was submitted is done.
    void drain();

    Load load() const;

    /// Time for which the jobs now waiting will keep the workers busy, at the pace of late; at least a second.
    std::chrono::seconds backlog() const;

private:
    /// Kinds of jobs that a thread does.
    enum class Lane { Any, Short };

    struct Waiting {
        JobId id = 0;
        api::Cost cost;
        Clock::time_point came;
        Job job;
    };
    struct Running {
        std::stop_source stop;
        Lane lane{};          ///< of the thread
        double expected = 0;  ///< seconds
        Clock::time_point started;
        std::optional<Clock::time_point> cancelled = {};
    };

    using Queue = FairQueue<Waiting>;

    void work(Lane lane, const std::stop_token& closing);
    static void run(const Job& job, const std::stop_token& stop);
    JobId push_locked(const std::string& client, Job job, const api::Cost& cost);
    bool has_room_locked(std::string_view client, bool is_short) const;
    std::size_t waiting_locked() const { return long_.size() + short_.size(); }
    bool is_idle_locked() const { return waiting_locked() == 0 && running_.empty(); }
    std::optional<Waiting> take_job_locked(Lane lane, std::optional<MemoryBudget::Lease>& memory);
    std::stop_token begin_locked(const Waiting& job, Lane lane);
    void finish_locked(JobId id);
    double waiting_seconds_locked() const;

    const std::size_t worker_count_;
    const std::size_t capacity_;

    MemoryBudget memory_;
    std::function<void(std::size_t running)> tell_ = [](std::size_t) {};

    mutable std::mutex mutex_;  ///< guards the members from here to `pace_`
    std::condition_variable_any job_waits_;
    std::condition_variable idle_;
    Queue long_;
    Queue short_;
    std::map<JobId, Running> running_;
    JobId last_id_ = 0;
    double pace_ = 1;  ///< time that jobs take over what was expected, the last ones weighing most

    std::vector<std::jthread> workers_;  ///< last: they use all the rest
};

}  // namespace ccdt::server
