// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "core/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Memory for requests and for their computations, in bytes. Requests and computations have separate shares, so that
/// waiting requests cannot take the memory that running computations need.
struct ComputeMemory {
    std::size_t total = 0;
    std::size_t jobs = 0;  ///< three quarters of the total: computations, including their answers until they are sent
    std::size_t requests = 0;  ///< a quarter of the total: requests, from the arrival of the body until they are done
};

/// Computes how much memory the configured shares leave for requests and computations.
/// @param resident  resident memory of the server process at its start, in bytes
/// Errors (Malformed): less than 192 MiB is left.
Result<ComputeMemory> memory_to_compute_with(const Config& config, std::size_t resident);

}  // namespace ccdt::server
