#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/result.h"
#include "server/jobs/job.h"
#include "server/work/compute_request.h"

namespace ccdt::server {

/// Whoever wants to know what happens to the jobs of a store, by the hand of any server. Called by any thread, one at a
/// time; may not use the store.
class JobListener {
public:
    virtual ~JobListener() = default;

    virtual void work() = 0;                          ///< there may be a job to claim
    virtual void changed(const std::string& id) = 0;  ///< a job stands elsewhere than before
    virtual void stop(const std::string& id) = 0;     ///< a job was cancelled: nobody is to run it
    virtual void missed() = 0;                        ///< any of these may have happened, unheard
};

/// Keeps jobs, the request until they end and then the result; whose turn it is; and which server runs what.
///
/// A job is claimed by a server that then runs it, and is that one's for a while, its lease, which `hold` renews. Once
/// the lease has run out another may claim it, with a number greater than all before (`Job::claim`): whoever comes with
/// a number that is not the latest is told that the job is lost, and changes nothing. So each job ends once, whatever
/// becomes of servers. In the queue clients take turns as in FairQueue.
///
/// All times are of the store's clock, which all servers share. What a call has changed is kept once it returns, and
/// jobs outlive what uses the store as long as its place does; where a job stands while it runs need not. May be used
/// from any thread. No call takes longer for the number of jobs that have ended. Errors of all: LimitExceeded if there
/// is no room left, Unusable if what is kept is not what was written, Stopped if the place of the store cannot be
/// reached in time, Internal for anything else that it comes up with.
class JobStore {
public:
    /// Why a job was added, or not.
    enum class Added { Accepted, QueueFull, NoRoom };

    /// Whose a job is that was claimed: still the claimer's, nobody's, another's.
    enum class Owned { Still, Cancelled, Lost };

    struct Hold {
        Owned owned = Owned::Still;
        Time now;
    };

    /// What the store has taken of a result already.
    struct Taken {
        std::size_t pieces = 0;
        std::size_t bytes = 0;
    };

    /// Bytes of a piece of a result, at most.
    static constexpr std::size_t kPiece = std::size_t{1} << 20;

    struct Load {
        std::size_t queued = 0;   ///< jobs to claim
        std::size_t running = 0;  ///< jobs that are claimed
        std::size_t bytes = 0;    ///< that are kept

        bool operator==(const Load&) const = default;
    };

    virtual ~JobStore() = default;

    /// Whether other servers may use the same place.
    virtual bool is_shared() const { return false; }

    /// Whether a job that the client adds now would find the queue full. As in the pool, a client that has nothing
    /// there is let in where others have filled it, until it is twice as long.
    virtual Result<bool> is_full(std::string_view client) = 0;

    /// Adds a job unless there is one of that id, and writes down when. Where there is no room for its bytes, results
    /// are dropped, those of the jobs that ended first, and once there are none what is left of such jobs.
    virtual Result<Added> add(Job& job, const ComputeRequest& request) = 0;

    /// Claims the job whose turn it is, or one whose lease has run out, and counts a start.
    /// @param memory  bytes; jobs that take more are for others
    /// @returns       none if there is none
    virtual Result<std::optional<Job>> claim(std::size_t memory) = 0;

    /// @returns  none if the job is not there or has ended
    virtual Result<std::optional<ComputeRequest>> request(const std::string& id) = 0;

    /// Renews the lease of a job that was claimed, and writes down where it stands: waiting or, from the time of the
    /// first such call on, running.
    virtual Result<Hold> hold(const Job& job) = 0;

    /// Has a claimed job claimed by another, first of all; the start does not count.
    virtual Result<void> give_back(const Job& job) = 0;

    /// Takes the next piece of a claimed job's result, and makes room for it as `add` does (LimitExceeded). May be
    /// called again after an error. What comes of it goes with the claim, unless `finish` ends that with a result.
    /// @param before  what was taken by this claim
    /// @param piece   of at most kPiece bytes, and not empty
    /// @returns       false if it was another's, or cancelled
    virtual Result<bool> take(const Job& job, const Taken& before, std::string_view piece) = 0;

    /// Writes down how a claimed job has ended: its request goes, its result stays. Makes room for it as `add` does, of
    /// which a job without a result needs none (LimitExceeded). May be called again after an error.
    /// @param result  all of it, or what comes after the pieces that were taken, which may be nothing
    /// @returns       when it has ended; none if it was another's, or cancelled
    virtual Result<std::optional<Time>> finish(const Job& job, std::string_view result, const Taken& before) = 0;
    Result<std::optional<Time>> finish(const Job& job, std::string_view result) { return finish(job, result, {}); }

    /// Cancels a job that has not ended.
    /// @returns  the job, cancelled; none if it is not there or had ended
    virtual Result<std::optional<Job>> cancel(const std::string& id) = 0;

    /// @returns  whether there was such a job
    virtual Result<bool> remove(const std::string& id) = 0;

    /// @returns  none if there is no such job, or it has expired
    virtual Result<std::optional<Job>> find(const std::string& id) = 0;

    /// A piece of a result, whose pieces are `Job::result_bytes` together.
    /// @param number  from 0; less than there are
    /// @returns       none if the job is not there, or its result is not
    virtual Result<std::optional<std::string>> piece(const std::string& id, std::size_t number) = 0;

    /// All of a result, put together.
    /// @returns  none if the job is not there, or its result is not
    Result<std::optional<std::string>> result(const std::string& id);

    /// Removes some of the jobs that have expired.
    /// @returns  whether there may be more of them
    virtual Result<bool> forget() = 0;

    virtual Result<Load> load() = 0;

    /// Has a listener told what happens from now on; null: nobody. Returns once the last one is not told any more.
    /// Where news come from afar it is told that it missed some once they do.
    virtual void listen(JobListener* listener) = 0;

    /// Times that something was not as it had been written.
    virtual std::uint64_t damages() const { return 0; }

    /// Bytes that a job takes with its request or its result.
    static constexpr std::size_t bytes_of_job(std::size_t held) {
        constexpr std::size_t kRow = 1024;  // with its places in the indices
        return kRow + held;
    }

    /// @param result  bytes of it, as far as it came
    static tl::unexpected<Error> no_room_for(std::size_t result) {
        return failure(ErrorCode::LimitExceeded, "the result has " + std::to_string(result) +
                                                     " bytes or more, for which there is no room (job-bytes)");
    }

    /// Bytes that a request takes.
    static std::size_t bytes_of(const ComputeRequest& request) {
        return request.path.size() + request.query.size() + request.content_type.size() + request.accept.size() +
               request.body.size();
    }
};

/// Returns the digest of a piece of a stored body, by which the stores recognise damage.
/// @param id      of its job
/// @param number  of the piece in the body, from 0
std::string digest_of_piece(std::string_view id, std::size_t number, std::string_view piece);

}  // namespace ccdt::server
