#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "server/http/message.h"
#include "server/http/problem.h"

namespace ccdt::server {

enum class JobStatus { Queued, Running, Succeeded, Failed, Cancelled };

/// The word for clients, logs, figures and stores.
std::string_view name_of(JobStatus status);

/// @returns  none if there is no such word
std::optional<JobStatus> status_named(std::string_view name);

inline bool is_finished(JobStatus status) {
    return status != JobStatus::Queued && status != JobStatus::Running;
}

/// A moment as clients and the store keep it.
using Time = std::chrono::sys_time<std::chrono::milliseconds>;

inline Time time_now() {
    return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

struct JobProgress {
    double fraction = 0;  ///< 0 to 1, which it is only once the job has succeeded
    int iteration = 0;
    std::optional<double> variation;
};

/// A request that nobody waits for: all but its body.
struct Job {
    std::string id;
    std::string owner;        ///< name of the API key that it came with; empty: none
    std::string client;       ///< whose turn it takes
    std::string traceparent;  ///< of the request that it came with, well formed; empty: none
    api::Cost cost;
    JobStatus status = JobStatus::Queued;
    int starts = 0;           ///< runs begun that their server did not survive, and the one that runs
    std::uint64_t claim = 0;  ///< number of the latest claim, greater than those of all claims before it
    Time created;
    std::optional<Time> started;
    std::optional<Time> finished;
    JobProgress progress;
    std::optional<Problem> failure;  ///< if it has failed, as the synchronous answer would have said it

    // If it has succeeded:
    std::string media_type;
    std::size_t result_bytes = 0;
    bool partial = false;         ///< what there was by its deadline
    std::vector<Header> headers;  ///< that tell what the body may not
    bool dropped = false;         ///< the result had to make room
};

/// Writes headers as stores keep them, such that headers_in() reads the same.
std::string text_of(const std::vector<Header>& headers);

/// Reads headers that text_of() wrote. Other lines are skipped.
std::vector<Header> headers_in(std::string_view text);

/// The job's status document, application/json.
std::string status_json(const Job& job);

}  // namespace ccdt::server
