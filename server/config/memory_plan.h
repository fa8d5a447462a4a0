// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "core/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Default shares of the server's memory (--memory), in bytes:
///
/// | share | size |
/// |---|---|
/// | transfers | 256 MiB or four times the largest body, whichever is more, but at most a quarter of the memory |
/// | cache | a sixteenth of the memory, at most 64 MiB |
/// | jobs in memory | a sixteenth of the memory, at most 256 MiB |
///
/// Computations get the memory that remains after these shares and the programs themselves: see ComputeMemory.
struct MemoryShares {
    std::size_t transfers = 0;
    std::size_t cache = 0;
    std::size_t jobs = 0;
};

/// @param max_body  size limit of a body, in bytes
MemoryShares share_memory(std::size_t memory, std::size_t max_body);

/// Memory for requests and for their computations, in bytes. The two are separate, so that waiting requests cannot take
/// the memory of running ones.
struct ComputeMemory {
    std::size_t total = 0;
    std::size_t jobs = 0;      ///< three quarters: computations, including their answers until they are sent
    std::size_t requests = 0;  ///< a quarter: requests, from the arrival of the body until they are done
};

/// Computes how much memory the configured shares leave for computations.
/// @param resident  resident memory of the server process at its start, in bytes
/// Errors (Malformed): less than 192 MiB is left.
Result<ComputeMemory> memory_to_compute_with(const Config& config, std::size_t resident);

}  // namespace ccdt::server
