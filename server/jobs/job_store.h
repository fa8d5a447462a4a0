// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/jobs/job.h"
#include "server/requests/compute_request.h"

namespace ccdt::server {

/// Receives notifications about all changes in a store, including changes by other servers. The functions are called by
/// any thread, one at a time, and must not use the store.
class JobListener {
public:
    virtual ~JobListener() = default;

    virtual void work() = 0;                          ///< there may be a job to claim
    virtual void changed(const std::string& id) = 0;  ///< a job's state has changed
    virtual void stop(const std::string& id) = 0;     ///< a job was cancelled or removed; its run must stop
    virtual void missed() = 0;                        ///< notifications may have been lost
};

/// Stores jobs, their requests and results, the queue of waiting jobs, and the claims of servers to jobs.
///
/// A server claims a job before it runs the job. The claim holds for a limited time, the lease, which `renew` extends.
/// After the lease has expired, another server may claim the job. Each claim has a number greater than all earlier ones
/// (`Job::claim`). A call with the number of an earlier claim reports that the job is lost, and changes nothing. So
/// each job ends only once, even if servers crash. The queue is fair between clients, like FairQueue: finish() replaces
/// the estimated seconds of a job by `Job::used`.
///
/// All times are read from the store's clock, which all servers share. Changes are durable when a call returns, except
/// for the progress of a running job. The duration of a call does not depend on the number of finished jobs.
/// Thread-safe. Errors of all calls: LimitExceeded if the capacity is exhausted, Unusable if stored data is damaged,
/// Stopped if the storage cannot be reached in time, Internal for all other failures.
class JobStore {
public:
    /// Whether a job was added, or the reason for the refusal.
    enum class Added { Accepted, QueueFull, StoreFull };

    /// The state of a claim: it is still valid, the job was cancelled, or another server has claimed the job.
    enum class Owned { Still, Cancelled, Lost };

    struct Renewal {
        Owned owned = Owned::Still;
        Time now;
    };

    /// Size of the part of a result that is already stored.
    struct StoredPart {
        std::size_t pieces = 0;
        std::size_t bytes = 0;
    };

    /// Maximum size of a piece of a result, in bytes.
    static constexpr std::size_t kPiece = std::size_t{1} << 20;

    struct Load {
        std::size_t queued = 0;   ///< jobs that can be claimed
        std::size_t running = 0;  ///< claimed jobs
        std::size_t bytes = 0;    ///< stored bytes

        bool operator==(const Load&) const = default;
    };

    /// The webhook of a finished job: a message to the URL `Job::callback` about the end of the job.
    struct Webhook {
        Job job;
        int attempts = 1;  ///< number of attempts to send the webhook, including the one that begins now
    };

    virtual ~JobStore() = default;

    /// Whether several servers may use the same storage.
    virtual bool is_shared() const { return false; }

    /// Whether add() would refuse a job of this client. As in WorkerPool, a client without a queued job is admitted to
    /// a full queue, until the queue is twice as long as its limit.
    virtual Result<bool> is_full(std::string_view client) = 0;

    /// Adds a job and sets its time of creation. Does nothing if a job with this id exists. To free space, deletes the
    /// results of finished jobs, starting with the job that ended first, and then whole finished jobs.
    virtual Result<Added> add(Job& job, const ComputeRequest& request) = 0;

    /// Claims the next job in the queue, or a job whose lease has expired, and increments `Job::starts`.
    /// @param memory  limit in bytes; jobs that need more memory are left to other servers
    /// @returns       the claimed job; none if no job can be claimed
    virtual Result<std::optional<Job>> claim(std::size_t memory) = 0;

    /// Reads the request of a job; none if the job does not exist or has ended.
    virtual Result<std::optional<ComputeRequest>> request(const std::string& id) = 0;

    /// Renews the lease of a claimed job, and stores its status and progress. The first call with the status Running
    /// sets the stored `Job::started`.
    virtual Result<Renewal> renew(const Job& job) = 0;

    /// Returns a claimed job to the front of the queue.
    /// @param counted  false: decrements `Job::starts`, because this run does not count as a start
    virtual Result<void> requeue(const Job& job, bool counted) = 0;

    /// Appends a piece to the result of a claimed job. Frees space as add() does. Error: LimitExceeded if there is not
    /// enough space. May be repeated after an error. The pieces are deleted unless finish() is called with a result.
    /// @param before  the part of the result that is already stored
    /// @param piece   1 to kPiece bytes
    /// @returns       false if the job was lost or cancelled
    virtual Result<bool> append_piece(const Job& job, const StoredPart& before, std::string_view piece) = 0;

    /// Stores the end of a claimed job: deletes its request, and stores its result. Frees space for the result as add()
    /// does. Error: LimitExceeded if there is not enough space. A job without a result needs no space. May be repeated
    /// after an error.
    /// @param result  the whole result, or the part after the stored pieces, which may be empty
    /// @returns       time of the end; none if the job was lost or cancelled
    virtual Result<std::optional<Time>> finish(const Job& job, std::string_view result, const StoredPart& before) = 0;
    Result<std::optional<Time>> finish(const Job& job, std::string_view result) { return finish(job, result, {}); }

    /// Cancels a job that has not ended.
    /// @returns  the cancelled job; none if the job does not exist or had ended
    virtual Result<std::optional<Job>> cancel(const std::string& id) = 0;

    /// Claims a webhook that is due, for an attempt to send it, and counts the attempt. It is due when its job has
    /// ended. Other calls may claim it again after `lease` unless settle_webhook() was called. Jobs that are removed
    /// lose their webhooks.
    /// @returns  none if no webhook is due
    virtual Result<std::optional<Webhook>> claim_webhook(std::chrono::milliseconds lease) = 0;

    /// Ends an attempt to send the webhook of a job.
    /// @param pause  time until the webhook is due again; none: it needs no further attempt, and is forgotten
    virtual Result<void> settle_webhook(const std::string& id, std::optional<std::chrono::milliseconds> pause) = 0;

    /// Removes a job; returns whether it existed.
    virtual Result<bool> remove(const std::string& id) = 0;

    /// Reads a job; none if it does not exist or has expired.
    virtual Result<std::optional<Job>> find(const std::string& id) = 0;

    /// Reads a piece of a result. The sizes of all pieces add up to `Job::result_bytes`.
    /// @param number  from 0; less than the number of pieces
    /// @returns       none if the job or its result does not exist
    virtual Result<std::optional<std::string>> piece(const std::string& id, std::size_t number) = 0;

    /// Reads a whole result.
    /// @returns  none if the job or its result does not exist
    Result<std::optional<std::string>> result(const std::string& id);

    /// Removes some of the expired jobs.
    /// @returns  whether more expired jobs may be left
    virtual Result<bool> remove_expired() = 0;

    virtual Result<Load> load() = 0;

    /// Sets the listener of future changes; null: none. Waits until the previous listener is no longer being notified.
    /// If notifications come from another process, calls `missed` when they begin to arrive.
    virtual void listen(JobListener* listener) = 0;

    /// Returns the number of times that damaged stored data was found.
    virtual std::uint64_t damages() const { return 0; }

    /// Returns the bytes that a job takes in the store.
    /// @param held  bytes of its request or result
    static constexpr std::size_t bytes_of_job(std::size_t held) {
        constexpr std::size_t kRow = 1024;  // for the job's data, including index entries
        return kRow + held;
    }

    /// Returns the error for a result that exceeds the available space.
    /// @param result  bytes of the result received so far
    static tl::unexpected<Error> no_space_for(std::size_t result) {
        return failure(ErrorCode::LimitExceeded, "the result has at least " + std::to_string(result) +
                                                     " bytes, for which there is no space (job-bytes)");
    }

    /// Returns the size of a request in bytes.
    static std::size_t bytes_of(const ComputeRequest& request) {
        return request.path.size() + request.query.size() + request.content_type.size() + request.accept.size() +
               request.body.size();
    }
};

/// Returns the digest of a piece of a stored body, with which stores detect damage.
/// @param id      id of the job
/// @param number  number of the piece in the body, from 0
std::string digest_of_piece(std::string_view id, std::size_t number, std::string_view piece);

}  // namespace ccdt::server
