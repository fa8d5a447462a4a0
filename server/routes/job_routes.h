#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "server/http/connection.h"
#include "server/http/message.h"
#include "server/http/problem.h"
#include "server/jobs/jobs.h"
#include "server/work/memory_budget.h"

namespace ccdt::server {

/// Answers what clients ask about their jobs. May be used from any thread.
class JobRoutes {
public:
    /// @param memory  what results take on their way to clients
    /// Jobs and memory must outlive it, and every answer that streams.
    JobRoutes(Jobs& jobs, MemoryBudget& memory, std::chrono::milliseconds ping)
        : jobs_(jobs), memory_(memory), ping_(ping) {}

    HttpResult<Response> status(const std::string& id, const Connection& connection) const;
    HttpResult<Response> result(const std::string& id, std::string_view if_none_match, const Connection& connection);
    HttpResult<Response> remove(const std::string& id, const Connection& connection);
    HttpResult<Response> events(const std::string& id, const Connection& connection) const;

private:
    Stream stream_of(const Job& job, std::string first) const;
    void send_events(Jobs::Watch watch, const Connection& connection, const Send& send) const;

    Jobs& jobs_;
    MemoryBudget& memory_;
    const std::chrono::milliseconds ping_;
};

/// Answers that a job was accepted.
Response accepted(const Job& job);

}  // namespace ccdt::server
