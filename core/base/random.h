// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace ccdt {

/// A stream of pseudo-random numbers, identical on every machine: SplitMix64 (Steele, Lea, Flood 2014). The seed and
/// the number of the stream determine the sequence.
class Random {
public:
    Random(std::uint64_t seed, std::uint64_t stream) : state_(mix(mix(seed) + stream * kGamma)) {}

    std::uint64_t bits() { return mix(state_ += kGamma); }

    /// Returns a uniform number in the open interval (0, 1).
    double uniform() { return (static_cast<double>(bits() >> 12) + 0.5) * 0x1p-52; }

private:
    static constexpr std::uint64_t kGamma = 0x9e3779b97f4a7c15;

    static constexpr std::uint64_t mix(std::uint64_t z) {
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
        z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
        return z ^ (z >> 31);
    }

    std::uint64_t state_;
};

}  // namespace ccdt
