// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stop_token>

#include "ccdt/abi.h"

namespace ccdt::v2 {

/// State of a running computation.
struct Progress {
    double done = 0;       ///< completed share of the work, in (0, 1) and never decreasing; an estimate
    double variation = 0;  ///< capacity variation after the last completed iteration
};

/// Lets a caller stop, observe and parallelise a computation. Results do not depend on the number of threads.
struct Control {
    std::stop_token stop = {};  ///< polled at least once per pass over the points, so that a stop takes little time

    /// Called several times while points move, on the thread that called the library; may be empty. An exception that
    /// it throws ends the computation and reaches the caller.
    std::function<void(const Progress&)> progress = {};

    unsigned threads = 0;  ///< number of threads, the caller's included; 0: one for each processor
};

}  // namespace ccdt::v2
