// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "server/config/config.h"

namespace ccdt::server {

/// The state of one part of the server.
struct Finding {
    enum class State {
        Good,
        Weak,   ///< the server starts, but with a fault
        Wrong,  ///< the server does not start
    };
    std::string part;
    State state = State::Good;
    std::string words;
};

/// Checks everything that the server needs to start with this configuration. The checks do not depend on each other.
/// They cover the sibling programs and their sandbox, the key files, the folder of pictures, memory, the folder of
/// jobs, each Redis, the listening address.
///
/// Nothing is served, claimed or written. Stored jobs stay as they are, and another server that uses their folder is
/// not detected. Started programs are ended again.
std::vector<Finding> check(const Config& config);

/// Whether the server would start.
bool would_start(const std::vector<Finding>& findings);

/// Returns one line for each finding.
std::string describe(const std::vector<Finding>& findings);

}  // namespace ccdt::server
