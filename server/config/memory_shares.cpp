// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/config/memory_shares.h"

#include <algorithm>

namespace ccdt::server {
namespace {

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

/// Default memory for bodies and answers in transfer. Time-outs of all clients shrink once half of it is taken. With
/// less memory, a single large answer would take half of it.
constexpr std::size_t kTransfers = 256 * kMebibyte;
constexpr std::size_t kBodiesAtOnce = 4;
constexpr std::size_t kMemoryPerTransferred = 4;

constexpr std::size_t kCache = 64 * kMebibyte;
constexpr std::size_t kJobs = 256 * kMebibyte;
constexpr std::size_t kMemoryPerStoredByte = 16;  ///< the cache and the jobs each get 1/16 of the memory

constexpr std::size_t kPrograms = 192 * kMebibyte;
constexpr std::size_t kMemoryPerWorker = 96 * kMebibyte;

}  // namespace

MemoryShares share_memory(std::size_t memory, std::size_t max_body) {
    const std::size_t rest = memory - std::min(memory, kPrograms);
    return {std::min(std::max(kTransfers, kBodiesAtOnce * max_body), rest / kMemoryPerTransferred),
            std::min(kCache, rest / kMemoryPerStoredByte), std::min(kJobs, rest / kMemoryPerStoredByte)};
}

std::size_t growth_for(std::size_t missing) {
    // 1/4 for transfers, 1/16 each for the cache and for jobs, and 1/12 for the 8 MiB of a worker's two processes.
    constexpr std::size_t kWorker = 8 * kMebibyte;
    return (missing + kWorker) / 13 * 24 + 24;
}

std::size_t default_memory(std::size_t available) {
    constexpr std::size_t kSmallContainer = 512 * kMebibyte, kForSmallContainer = 320 * kMebibyte;
    return available < kSmallContainer ? available / 2 : std::max(available / 2, kForSmallContainer);
}

std::size_t default_workers(std::size_t cores, std::size_t memory) {
    return std::clamp<std::size_t>(memory / kMemoryPerWorker, 1, cores);
}

}  // namespace ccdt::server
