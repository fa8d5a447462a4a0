// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>

namespace ccdt::server {

/// Limits of jobs.
struct JobLimits {
    std::size_t waiting = 1'000;                 ///< number of jobs that may wait
    std::size_t bytes = std::size_t{1} << 30;    ///< capacity of the store
    std::chrono::milliseconds ttl{3'600'000};    ///< time that a job is kept after its end
    std::chrono::milliseconds timeout{600'000};  ///< from the start of a run to its result
    std::chrono::milliseconds lease{
        15'000};  ///< time after which other servers may take a job whose claim was not renewed
    std::chrono::milliseconds ping{15'000};  ///< longest time between two messages of an event stream
};

}  // namespace ccdt::server
