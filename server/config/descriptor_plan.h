// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "core/base/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Division of the file descriptors that the server may open (`ulimit -n`).
struct DescriptorPlan {
    std::size_t allowed = 0;    ///< limit of descriptors of this process
    std::size_t wanted = 0;     ///< number needed if all connections allowed by the flags are open
    Capacity::Limits capacity;  ///< limits set by the flags, reduced if the descriptors do not suffice

    bool fits() const { return wanted <= allowed; }
};

/// Limits of connections to the port of /metrics.
inline constexpr Capacity::Limits kMetricsCapacity{
    .connections = 16, .reserve = 0, .streams = 0, .refused = 4, .per_address = 0, .bytes = std::size_t{16} << 20};

/// Returns the number of descriptors needed if all connections allowed by the flags are open.
std::size_t wanted_descriptors(const Config& config);

/// Divides the descriptors. Reserves those of the server itself, its computations and its connections to Redis. The
/// connections of clients share the remaining ones.
/// @param allowed  limit of descriptors of this process
/// Errors (Unusable): too few descriptors for a useful server; the message names the limit and the minimum.
Result<DescriptorPlan> share_descriptors(const Config& config, std::size_t allowed);

/// Describes the limits of connections and, if they were reduced, the reason.
std::string describe(const DescriptorPlan& plan);

}  // namespace ccdt::server
