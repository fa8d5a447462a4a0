// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace ccdt::server {

/// Default shares of the server's memory (--memory), in bytes. 192 MiB are set apart for the programs themselves. Of
/// the remaining memory:
///
/// | share | size |
/// |---|---|
/// | transfers | 256 MiB or four times the largest body, whichever is more, but at most a quarter |
/// | cache | a sixteenth, at most 64 MiB |
/// | jobs in memory | a sixteenth, at most 256 MiB |
///
/// The rest is for requests and their computations: see memory_plan.h.
struct MemoryShares {
    std::size_t transfers = 0;
    std::size_t cache = 0;
    std::size_t jobs = 0;
};

/// Returns the default shares of `memory` bytes.
/// @param max_body  size limit of a body, in bytes
MemoryShares share_memory(std::size_t memory, std::size_t max_body);

/// Returns by how many bytes a memory that is `missing` bytes too small for its fixed parts must grow, because the
/// shares and the default number of workers grow with it.
std::size_t growth_for(std::size_t missing);

/// Returns the default of --memory: half of the memory of the machine or container, but 320 MiB if it has 512 to 640
/// MiB.
/// @param available  memory of the machine or container, in bytes
std::size_t default_memory(std::size_t available);

/// Returns the default number of workers: one per core, but at most one per 96 MiB of the memory.
std::size_t default_workers(std::size_t cores, std::size_t memory);

}  // namespace ccdt::server
