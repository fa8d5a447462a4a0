#pragma once

#include <chrono>
#include <cstddef>

namespace ccdt::server {

/// Limits of what jobs may take.
struct JobLimits {
    std::size_t waiting = 1'000;                 ///< jobs that may wait to be run
    std::size_t bytes = std::size_t{1} << 30;    ///< that the store may hold
    std::chrono::milliseconds ttl{3'600'000};    ///< that a job is kept after its end
    std::chrono::milliseconds timeout{600'000};  ///< from the start of its run to the result
    std::chrono::milliseconds lease{15'000};     ///< for which a server that is not heard of keeps the jobs it runs
    std::chrono::milliseconds ping{15'000};      ///< longest silence of a stream of events
};

}  // namespace ccdt::server
