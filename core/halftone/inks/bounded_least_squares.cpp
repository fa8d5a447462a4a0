// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/bounded_least_squares.h"

#include <numeric>

namespace ccdt {

BoundedLeastSquares::Numbers BoundedLeastSquares::minimize() const {
    constexpr int kMaxRounds = 100;  // a few suffice; the limit prevents an endless loop due to rounding
    Numbers x{};
    States states{};
    for (int round = 0; round < kMaxRounds; ++round) {
        const auto next = to_free(x, states);
        if (!next) break;
        states[*next] = State::Free;
        while (!step(x, states, solve(x, states))) {
        }
    }
    return x;
}

/// Returns the variable at a bound whose release decreases the objective fastest; none if no release decreases it.
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

/// Returns the unconstrained minimum over the free variables. G is positive definite, so no pivoting is needed.
BoundedLeastSquares::Numbers BoundedLeastSquares::solve(const Numbers& x, const States& states) const {
    std::array<std::size_t, kMaxNumbers> free{};
    std::size_t n = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (states[i] == State::Free) free[n++] = i;
    }
    std::array<Numbers, kMaxNumbers> rows{};
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

/// Moves x towards `to` until a variable reaches a bound, and holds that variable there.
/// @returns  whether x reached `to`
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
