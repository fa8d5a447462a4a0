#pragma once

#include <string>
#include <vector>

#include "server/config/config.h"

namespace ccdt::server {

/// What was found of a part of the server.
struct Finding {
    enum class State {
        Good,
        Weak,   ///< the server starts, though something is not as it should be
        Wrong,  ///< it does not start
    };
    std::string part;
    State state = State::Good;
    std::string words;
};

/// Tries what the server needs to start with this configuration, each thing for itself: the programs beside it and
/// their sandbox, the files of keys, the folder of pictures, memory, the folder of jobs, what Redis it uses, the
/// address to listen on.
///
/// Nothing is served, taken up or written: jobs that are stored stay as they are, and that another server uses their
/// folder is not noticed. What is started is ended again.
std::vector<Finding> check(const Config& config);

/// Whether the server would start.
bool would_start(const std::vector<Finding>& findings);

/// A line for each finding.
std::string describe(const std::vector<Finding>& findings);

}  // namespace ccdt::server
