// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/config/descriptor_plan.h"

#include <algorithm>
#include <string>

#include "server/pool/thread_share.h"

namespace ccdt::server {
namespace {

/// Descriptors reserved for the server itself (helper programs, log, listening socket, job database) and for each
/// computation. An idle server uses 12 to 14, a computation 3.
constexpr std::size_t kServerDescriptors = 32;
constexpr std::size_t kDescriptorsPerComputation = 4;

/// Maximum number of connections to one Redis, including one for notifications.
constexpr std::size_t kDescriptorsPerRedis = 17;

/// Minimum limits of connections with which the server starts, unless its flags set lower limits.
constexpr std::size_t kMinConnections = 16;
constexpr std::size_t kMinReserve = 8;
constexpr std::size_t kMinStreams = 4;
constexpr std::size_t kMinRefused = 4;

std::size_t connections_of(const Capacity::Limits& limits) {
    return limits.connections + limits.reserve + limits.streams + limits.refused;
}

std::size_t own_descriptors(const Config& config) {
    const std::size_t redis = config.redis.has_value() + config.cache_redis.has_value() + config.rate_redis.has_value();
    return kServerDescriptors + kDescriptorsPerComputation * max_computations(config.workers) +
           kDescriptorsPerRedis * redis + (config.metrics_port ? 1 + connections_of(kMetricsCapacity) : 0);
}

Capacity::Limits least(Capacity::Limits limits) {
    limits.connections = std::min(limits.connections, kMinConnections);
    limits.reserve = std::min(limits.reserve, kMinReserve);
    limits.streams = std::min(limits.streams, kMinStreams);
    limits.refused = std::min(limits.refused, kMinRefused);
    return limits;
}

}  // namespace

std::size_t wanted_descriptors(const Config& config) {
    return own_descriptors(config) + connections_of(config.capacity);
}

Result<DescriptorPlan> share_descriptors(const Config& config, std::size_t allowed) {
    DescriptorPlan plan{allowed, wanted_descriptors(config), config.capacity};
    if (plan.fits()) return plan;
    const Capacity::Limits lowest = least(config.capacity);
    const std::size_t needed = own_descriptors(config) + connections_of(lowest);
    if (allowed < needed)
        return failure(ErrorCode::Unusable, "the limit of open files (ulimit -n) is " + std::to_string(allowed) +
                                                ": at least " + std::to_string(needed) + " are needed");
    const std::size_t spare = allowed - needed;
    const std::size_t missing = plan.wanted - needed;
    const auto scale = [=](std::size_t& wanted, std::size_t low) { wanted = low + (wanted - low) * spare / missing; };
    scale(plan.capacity.connections, lowest.connections);
    scale(plan.capacity.reserve, lowest.reserve);
    scale(plan.capacity.streams, lowest.streams);
    scale(plan.capacity.refused, lowest.refused);
    return plan;
}

std::string describe(const DescriptorPlan& plan) {
    const Capacity::Limits& limits = plan.capacity;
    std::string limits_text = std::to_string(limits.connections) + " connections, " + std::to_string(limits.reserve) +
                              " in reserve, " + std::to_string(limits.streams) + " streams";
    if (plan.fits()) return limits_text;
    return "the limit of open files (ulimit -n) is " + std::to_string(plan.allowed) + ", " +
           std::to_string(plan.wanted) + " are wanted: at most " + limits_text;
}

}  // namespace ccdt::server
