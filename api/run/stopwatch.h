// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>

namespace ccdt::api {

/// Measures the time of the stages of a computation.
class Stopwatch {
public:
    /// Returns the milliseconds since the previous call, or since construction, and starts the next lap.
    double lap() {
        const auto now = Clock::now();
        const std::chrono::duration<double, std::milli> elapsed = now - start_;
        start_ = now;
        return elapsed.count();
    }

private:
    using Clock = std::chrono::steady_clock;

    Clock::time_point start_ = Clock::now();
};

}  // namespace ccdt::api
