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

}  // namespace

MemoryShares share_memory(std::size_t memory, std::size_t max_body) {
    return {std::min(std::max(kTransfers, kBodiesAtOnce * max_body), memory / kMemoryPerTransferred),
            std::min(kCache, memory / kMemoryPerStoredByte), std::min(kJobs, memory / kMemoryPerStoredByte)};
}

}  // namespace ccdt::server
