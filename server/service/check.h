// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "server/config/config.h"

namespace ccdt::server {

/// The result of the check of one part of the server.
struct Finding {
    enum class State {
        Good,
        Weak,   ///< the server starts, but the part has a fault
        Wrong,  ///< the server does not start
    };
    std::string part;
    State state = State::Good;
    std::string words;
};

/// Checks everything that the server needs to start with a configuration: its programs and their sandbox, the key
/// files, the folder of pictures, memory, descriptors, the folder of jobs, each Redis, the listening address.
///
/// Serves no requests, claims no jobs and writes nothing. Does not detect another server that uses the folder of jobs.
std::vector<Finding> check(const CommandLine& command);

/// Whether the server would start.
bool would_start(const std::vector<Finding>& findings);

/// Returns one line for each finding.
std::string describe(const std::vector<Finding>& findings);

}  // namespace ccdt::server
