// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "core/base/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Memory for requests and for computations, in bytes. The shares are separate, so that waiting requests cannot take
/// the memory that computations need.
struct ComputeMemory {
    std::size_t total = 0;
    std::size_t jobs = 0;      ///< 3/4 of the total: computations, and their answers until they are sent
    std::size_t requests = 0;  ///< 1/4 of the total: requests, from the arrival of the body to the answer
};

/// Returns the memory for requests and computations: the configured memory without all other shares.
/// @param resident  resident memory of the server process at its start, in bytes
/// Errors (Malformed): less than 48 MiB are left. The message names a memory that suffices.
Result<ComputeMemory> memory_to_compute_with(const Config& config, std::size_t resident);

}  // namespace ccdt::server
