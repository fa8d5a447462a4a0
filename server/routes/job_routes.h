// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string>

#include "server/http/byte_range.h"
#include "server/http/connection.h"
#include "server/http/message.h"
#include "server/http/problem.h"
#include "server/jobs/job_service.h"
#include "server/jobs/result_reader.h"
#include "server/pool/memory_budget.h"

namespace ccdt::server {

/// Answers requests about jobs. Thread-safe.
class JobRoutes {
public:
    /// @param memory  budget for results while they are sent
    /// @param ping    maximum time between two messages of an event stream
    /// `jobs`, `results` and `memory` must outlive this object and all streamed answers.
    JobRoutes(JobService& jobs, ResultReader& results, MemoryBudget& memory, std::chrono::milliseconds ping)
        : jobs_(jobs), results_(results), memory_(memory), ping_(ping) {}

    HttpResult<Response> status(const std::string& id, const Connection& connection) const;
    HttpResult<Response> result(const std::string& id, const Request& request, const Connection& connection);
    HttpResult<Response> remove(const std::string& id, const Connection& connection);
    HttpResult<Response> events(const std::string& id, const Connection& connection) const;

private:
    HttpResult<Response> part(const Job& job, const ByteRange& range);
    Stream stream_of(const Job& job, std::string first) const;
    void send_events(JobService::Watch watch, const Connection& connection, const Send& send) const;

    JobService& jobs_;
    ResultReader& results_;
    MemoryBudget& memory_;
    const std::chrono::milliseconds ping_;
};

/// Makes the problem for a request for a result that does not exist.
tl::unexpected<Problem> no_result(const Job& job);

/// Makes the 202 answer with the location of an accepted job.
Response accepted_response(const Job& job);

}  // namespace ccdt::server
