// SPDX-License-Identifier: GPL-3.0-or-later
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

/// Returns the word for a status, as used in answers, logs, metrics and stores.
std::string_view name_of(JobStatus status);

/// Returns the status that a word names, as the inverse of name_of(); none if the word is unknown.
std::optional<JobStatus> status_named(std::string_view name);

inline bool is_finished(JobStatus status) {
    return status != JobStatus::Queued && status != JobStatus::Running;
}

/// A point in time, in milliseconds, as shown to clients and kept in stores.
using Time = std::chrono::sys_time<std::chrono::milliseconds>;

inline Time time_now() {
    return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

struct JobProgress {
    double fraction = 0;  ///< 0 to 1; below 1 until the job has succeeded
    int iteration = 0;
    std::optional<double> variation;
};

/// The state of a request that is computed in the background, without a waiting client. The request is stored
/// separately.
struct Job {
    std::string id;
    std::string owner;        ///< name of the API key of the request; empty: none
    std::string client;       ///< name of the client for fair queueing
    std::string traceparent;  ///< header of the request, if well-formed; empty: none
    std::string callback;     ///< URL of the webhook, see JobStore::claim_webhook(); empty: none
    api::Cost cost;
    std::size_t expected = 0;  ///< upper estimate of the size of the result, in bytes
    JobStatus status = JobStatus::Queued;
    int starts = 0;           ///< number of runs, including runs that a server crash interrupted
    std::uint64_t claim = 0;  ///< number of the latest claim, see JobStore
    double used = 0;          ///< processor time of the last run, in seconds; 0: unknown. Not stored
    Time created;
    std::optional<Time> started;
    std::optional<Time> finished;
    JobProgress progress;
    std::optional<Problem> failure;  ///< the problem that a synchronous answer would report

    // Members of jobs that have succeeded:
    std::string media_type;
    std::size_t result_bytes = 0;
    bool partial = false;         ///< whether the result is incomplete because of the deadline
    std::vector<Header> headers;  ///< see answer_headers()
    bool dropped = false;         ///< the result was deleted to free space
};

/// Serializes headers for stores; headers_in() is the inverse.
std::string text_of(const std::vector<Header>& headers);

/// Parses headers that text_of() wrote. Other lines are ignored.
std::vector<Header> headers_in(std::string_view text);

/// Returns the job's status document, application/json.
std::string status_json(const Job& job);

}  // namespace ccdt::server
