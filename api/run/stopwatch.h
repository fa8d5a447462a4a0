#pragma once

#include <chrono>

namespace ccdt::api {

/// Clock of the stages of a computation.
class Stopwatch {
public:
    /// Gives the milliseconds since the last lap, or since it was made.
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
