// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "core/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Shares of the file descriptors that the server may open (`ulimit -n`).
struct DescriptorPlan {
    std::size_t allowed = 0;    ///< limit of the process
    std::size_t wanted = 0;     ///< number needed for all connections that the flags allow
    Capacity::Limits capacity;  ///< the limits of the flags or, if they do not fit, proportionally lower ones

    bool fits() const { return wanted <= allowed; }
};

/// Number of descriptors that the server needs if all connections that the flags allow are open.
std::size_t wanted_descriptors(const Config& config);

/// Divides the descriptors. The server itself, its computations and its connections to Redis come first. The
/// connections of clients share the remaining descriptors.
/// @param allowed  limit of descriptors of this process
/// Errors (Unusable): too few for a useful server; the message names the limit and the need.
Result<DescriptorPlan> share_descriptors(const Config& config, std::size_t allowed);

/// Describes how many connections may be open and, if that is fewer than wanted, why.
std::string describe(const DescriptorPlan& plan);

}  // namespace ccdt::server
