// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/bounded_least_squares.h"

#include <numeric>

namespace ccdt {

BoundedLeastSquares::Numbers BoundedLeastSquares::minimize() const {
    constexpr int kMostRounds = 100;  // a few are needed; rounding must not make it endless
    Numbers x{};
    States states{};
    for (int round = 0; round < kMostRounds; ++round) {
        const auto next = to_free(x, states);
        if (!next) break;
        states[*next] = State::Free;
        while (!step(x, states, solve(x, states))) {
        }
    }
    return x;
}

/// The number at an end of its range that gains most by leaving it.
std::optional<std::size_t> BoundedLeastSquares::to_free(const Numbers& x, const States& states) const {
    double most = 1e-12;
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < count; ++i) {
        if (states[i] == State::Free) continue;
        const double slope = wanted[i] - std::inner_product(x.begin(), x.end(), products[i].begin(), 0.0);
        const double gain = states[i] == State::AtZero ? slope : -slope;
        if (gain <= most) continue;
        most = gain;
        found = i;
    }
    return found;
}

/// The minimum over the free numbers, their range left aside. Elimination needs no pivots, G being positive definite.
BoundedLeastSquares::Numbers BoundedLeastSquares::solve(const Numbers& x, const States& states) const {
    std::array<std::size_t, kMostNumbers> free{};
    std::size_t n = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (states[i] == State::Free) free[n++] = i;
    }
    std::array<Numbers, kMostNumbers> rows{};
    Numbers right{};
    for (std::size_t i = 0; i < n; ++i) {
        right[i] = wanted[free[i]];
        for (std::size_t k = 0; k < n; ++k) rows[i][k] = products[free[i]][free[k]];
        for (std::size_t k = 0; k < count; ++k) {
            if (states[k] == State::AtOne) right[i] -= products[free[i]][k];
        }
    }
    for (std::size_t pivot = 0; pivot < n; ++pivot) {
        for (std::size_t i = pivot + 1; i < n; ++i) {
            const double factor = rows[i][pivot] / rows[pivot][pivot];
            for (std::size_t k = pivot; k < n; ++k) rows[i][k] -= factor * rows[pivot][k];
            right[i] -= factor * right[pivot];
        }
    }
    Numbers to = x;
    for (std::size_t i = n; i-- > 0;) {
        double value = right[i];
        for (std::size_t k = i + 1; k < n; ++k) value -= rows[i][k] * to[free[k]];
        to[free[i]] = value / rows[i][i];
    }
    return to;
}

/// Goes towards a place as far as all numbers stay in range; the one that comes to an end of it first stays there.
/// @returns  whether it went all the way
bool BoundedLeastSquares::step(Numbers& x, States& states, const Numbers& to) const {
    double share = 1;
    std::optional<std::size_t> first;
    for (std::size_t i = 0; i < count; ++i) {
        if (states[i] != State::Free || (to[i] >= 0 && to[i] <= 1)) continue;
        const double reach = ((to[i] < 0 ? 0 : 1) - x[i]) / (to[i] - x[i]);
        if (first && reach >= share) continue;
        share = reach;
        first = i;
    }
    for (std::size_t i = 0; i < count; ++i) x[i] += share * (to[i] - x[i]);
    if (!first) return true;
    const bool is_below = to[*first] < 0;
    states[*first] = is_below ? State::AtZero : State::AtOne;
    x[*first] = is_below ? 0 : 1;
    return false;
}

}  // namespace ccdt
