#pragma once

#include <algorithm>

namespace ccdt::api {

inline constexpr double kMicrosecond = 1e-6;  ///< seconds

/// Memory and time that a stage of a computation takes.
struct Estimate {
    double bytes = 0;
    double seconds = 0;

    /// Adds what is there at the same time.
    Estimate operator+(const Estimate& other) const { return {bytes + other.bytes, seconds + other.seconds}; }
    Estimate operator*(double times) const { return {bytes * times, seconds * times}; }
};

/// Runs one stage after the other, each giving its memory back.
inline Estimate then(const Estimate& a, const Estimate& b) {
    return {std::max(a.bytes, b.bytes), a.seconds + b.seconds};
}

}  // namespace ccdt::api
