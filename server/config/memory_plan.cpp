// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/config/memory_plan.h"

#include <string>

#include "server/config/memory_shares.h"
#include "server/pool/thread_share.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

/// Memory of idle decoder processes (70 MiB), and of the threads that the server creates after its start.
constexpr std::size_t kOthers = 160 * kMebibyte;

/// Memory of an idle computation process, or of the fork server.
constexpr std::size_t kProcess = 4 * kMebibyte;

constexpr std::size_t kMinForComputations = 48 * kMebibyte;

std::string mebibytes(std::size_t bytes) {
    return std::to_string(bytes / kMebibyte) + " MiB";
}

}  // namespace

Result<ComputeMemory> memory_to_compute_with(const Config& config, std::size_t resident) {
    const std::size_t kept = config.data_dir.empty() && !config.redis ? config.jobs.bytes : 0;
    const std::size_t processes = (max_computations(config.workers) + 1) * kProcess;  // 1 more: the fork server
    const std::size_t taken = resident + kOthers + processes + config.capacity.bytes + config.cache + kept;
    const std::size_t needed = taken + kMinForComputations;
    if (config.memory < needed) {
        const std::size_t enough = config.memory + growth_for(needed - config.memory) + kMebibyte;
        return failure(ErrorCode::Malformed,
                       "a memory of " + mebibytes(config.memory) + " leaves too little to compute with: " +
                           mebibytes(enough) + " suffice (--memory; by default half of the machine's or container's)");
    }
    const std::size_t total = config.memory - taken;
    return ComputeMemory{total, total / 4 * 3, total / 4};
}

}  // namespace ccdt::server
