// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

namespace ccdt::api {

inline constexpr double kMicrosecond = 1e-6;  ///< seconds

/// Memory and time of a stage of a computation.
struct Estimate {
    double bytes = 0;
    double seconds = 0;

    /// Combines two stages that run one after the other and hold their memory at the same time.
    Estimate operator+(const Estimate& other) const { return {bytes + other.bytes, seconds + other.seconds}; }
    Estimate operator*(double times) const { return {bytes * times, seconds * times}; }
};

/// Combines two stages that run one after the other. The first releases its memory before the second begins.
inline Estimate then(const Estimate& a, const Estimate& b) {
    return {std::max(a.bytes, b.bytes), a.seconds + b.seconds};
}

}  // namespace ccdt::api
