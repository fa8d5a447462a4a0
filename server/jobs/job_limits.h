// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>

namespace ccdt::server {

/// Limits of jobs.
struct JobLimits {
    std::size_t waiting = 1'000;                 ///< maximum number of waiting jobs
    std::size_t bytes = std::size_t{1} << 30;    ///< capacity of the store, in bytes
    std::chrono::milliseconds ttl{3'600'000};    ///< time for which a job is kept after its end
    std::chrono::milliseconds timeout{600'000};  ///< maximum duration of a run
    std::chrono::milliseconds lease{15'000};     ///< time for which a claim is valid after its start or renewal
    std::chrono::milliseconds ping{15'000};      ///< maximum time between two messages of an event stream
};

}  // namespace ccdt::server
