// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace ccdt::server {

/// Default shares of the server's memory (--memory), in bytes:
///
/// | share | size |
/// |---|---|
/// | transfers | 256 MiB or four times the largest body, whichever is more, but at most a quarter of the memory |
/// | cache | a sixteenth of the memory, at most 64 MiB |
/// | jobs in memory | a sixteenth of the memory, at most 256 MiB |
///
/// The programs themselves need memory, too. The rest is for requests and their computations: see memory_plan.h.
struct MemoryShares {
    std::size_t transfers = 0;
    std::size_t cache = 0;
    std::size_t jobs = 0;
};

/// Returns the default shares of `memory` bytes.
/// @param max_body  size limit of a body, in bytes
MemoryShares share_memory(std::size_t memory, std::size_t max_body);

}  // namespace ccdt::server
