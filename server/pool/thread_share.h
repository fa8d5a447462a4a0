// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>

namespace ccdt::server {

/// Returns the maximum number of computations at the same time: one for each worker, one in the slot of short jobs, and
/// as many that have left this slot as there are workers; see WorkerPool.
constexpr std::size_t max_computations(std::size_t workers) {
    return 2 * workers + 1;
}

/// Returns the number of threads that each computation may use, including those of idle workers.
/// @param workers      number of workers, >= 1
/// @param running      number of computations, including those of short requests
/// @param max_threads  limit for one computation, >= 1
inline std::size_t threads_for_each(std::size_t workers, std::size_t running, std::size_t max_threads) {
    return std::clamp<std::size_t>(workers / std::max<std::size_t>(running, 1), 1, max_threads);
}

}  // namespace ccdt::server
