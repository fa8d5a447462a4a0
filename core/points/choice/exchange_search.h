// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/geometry/point3.h"

namespace ccdt::choice {

/// Pair energy of two chosen points at the distance r, in units of their spacing: (1 - r^2 / reach^2)^6, plus
/// core (1 - r^2 / core_reach^2)^4. The first term removes long waves, the second one keeps points apart.
struct PairEnergy {
    float reach, core, core_reach;

    /// Returns the first term.
    /// @param square  r^2 / reach^2
    static double soft(double square) {
        const double rest = std::max(0.0, 1 - square), cube = rest * rest * rest;
        return cube * cube;
    }
};

/// Candidates, in any order.
struct SearchInput {
    std::span<const Point3> positions;  ///< [n >= 1], in a box from the origin; its longest side is 1
    std::span<const float> spacings;    ///< [n] wanted distance scale at each candidate, > 0
    std::span<const float> wanted;      ///< [n] energy that the chosen points around a candidate should have
    /// [n] logarithm of the number of candidates around each candidate. Without it, random moves would gather points
    /// where there are many candidates
    std::span<const float> crowding;
    std::span<const std::uint8_t> is_fixed;  ///< [n] 1 if the choice of the candidate must not change
    Point3 torus;                            ///< sides of a torus; 0 if the box is not a torus
};

struct SearchOptions {
    PairEnergy energy;
    double move_reach = 1;   ///< longest move, in spacings
    int passes = 1;          ///< number of passes over the chosen points
    std::uint64_t seed = 1;  ///< determines the random numbers
};

/// Improves a choice of candidates: moves chosen points to free candidates near them, so that the sum of pair energies
/// falls. Early passes also accept some moves to a higher energy (simulated annealing).
///
/// @param is_chosen  [n] 1 for chosen candidates; changed in place, with the same number of ones
/// @param stop       after a stop, the choice is valid, but less even
///
/// Deterministic for any number of threads: tiles of one colour of a checkerboard are independent of each other. O(n)
/// per pass for bounded numbers of candidates within a spacing.
void exchange(const SearchInput& input, const SearchOptions& options, std::span<std::uint8_t> is_chosen,
              const std::stop_token& stop, Executor& executor);

}  // namespace ccdt::choice
