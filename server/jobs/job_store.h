#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "server/jobs/job.h"
#include "server/work/compute_request.h"

namespace ccdt::server {

/// Keeps jobs: the request until they end, then the result.
///
/// What a call has changed is kept once it returns. May be used from any thread. No call takes longer for the number of
/// jobs kept, but for `unfinished`. Errors of all: LimitExceeded if there is no room left, Unusable if what is kept is
/// not what was written, Internal for anything else that the store's place comes up with.
class JobStore {
public:
    virtual ~JobStore() = default;

    virtual Result<void> add(const Job& job, const ComputeRequest& request) = 0;

    /// Jobs that have not finished, in the order in which they came.
    virtual Result<std::vector<Job>> unfinished() = 0;

    /// @returns  none if there is no such job
    virtual Result<std::optional<Job>> find(const std::string& id) = 0;

    /// @returns  none if the job is not there or has finished
    virtual Result<std::optional<ComputeRequest>> request(const std::string& id) = 0;

    /// @returns  none if the job is not there, or its result is not
    virtual Result<std::optional<std::string>> result(const std::string& id) = 0;

    /// Writes down where a job that has not finished stands.
    virtual Result<void> save(const Job& job) = 0;

    /// Writes down how a job has finished: its request goes, its result stays.
    virtual Result<void> finish(const Job& job, std::string_view result) = 0;

    /// @returns  whether there was such a job
    virtual Result<bool> remove(const std::string& id) = 0;

    /// Removes some of those that finished by then, oldest first.
    /// @returns  how many
    virtual Result<std::size_t> remove_finished(Time by, std::size_t most) = 0;

    /// Finds when the job that finished first did.
    virtual Result<std::optional<Time>> first_finished() = 0;

    /// Drops the result of the job that finished first of those that have one.
    /// @returns  false if none has
    virtual Result<bool> drop_oldest_result() = 0;

    /// Bytes that the jobs kept take.
    virtual std::size_t bytes() const = 0;

    /// Bytes that a job takes with its request or its result.
    static constexpr std::size_t bytes_of_job(std::size_t held) {
        constexpr std::size_t kRow = 1024;  // with its places in the indices
        return kRow + held;
    }
};

}  // namespace ccdt::server
