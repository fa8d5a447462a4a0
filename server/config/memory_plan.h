#pragma once

#include <cstddef>

#include "core/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Shares of the server's memory (--memory) in bytes, where flags do not set them:
///
/// | share | of it |
/// |---|---|
/// | transfers | at most a quarter: 256 MiB, or four of the largest bodies |
/// | cache | a sixteenth, at most 64 MiB |
/// | jobs in memory | a sixteenth, at most 256 MiB |
///
/// What is left of it by these and by the program itself is for computing: see ComputeMemory.
struct MemoryShares {
    std::size_t transfers = 0;
    std::size_t cache = 0;
    std::size_t jobs = 0;
};

/// @param max_body  bytes of the largest body
MemoryShares share_memory(std::size_t memory, std::size_t max_body);

/// Bytes for requests and for what is computed for them. They are apart, lest those that wait leave nothing to those
/// that run.
struct ComputeMemory {
    std::size_t total = 0;
    std::size_t jobs = 0;      ///< three quarters: what is computed, of which answers are a part until they are sent
    std::size_t requests = 0;  ///< a quarter: from their body on until they are done
};

/// Finds what the shares above leave to compute with.
/// @param resident  bytes that the program takes at the start, its libraries and processes that decode included
/// Errors (Malformed): less than 192 MiB.
Result<ComputeMemory> memory_to_compute_with(const Config& config, std::size_t resident);

}  // namespace ccdt::server
