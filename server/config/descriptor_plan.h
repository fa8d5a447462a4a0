#pragma once

#include <cstddef>

#include "core/result.h"
#include "server/config/config.h"

namespace ccdt::server {

/// Shares of the file descriptors that the server may have open (`ulimit -n`).
struct DescriptorPlan {
    std::size_t allowed = 0;    ///< the limit
    std::size_t wanted = 0;     ///< for all connections that the flags allow
    Capacity::Limits capacity;  ///< what the flags say or, if that is more than fits, a proportional part of it

    bool fits() const { return wanted <= allowed; }
};

/// Number of descriptors that all connections and everything else take.
std::size_t wanted_descriptors(const Config& config);

/// Shares out the descriptors so that none is missing for what the server does itself: its programs, pictures, jobs.
/// @param allowed  most descriptors of this process
/// Errors (Unusable): too few for a server of use; the message names the limit and the need.
Result<DescriptorPlan> share_descriptors(const Config& config, std::size_t allowed);

/// Describes how many connections may be open by a plan, and why not more.
std::string describe(const DescriptorPlan& plan);

}  // namespace ccdt::server
