// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <optional>

namespace ccdt {

/// Minimizes x' G x / 2 - w' x for x in [0, 1]^n, n up to 6.
///
/// G must be positive definite. Then the minimum is unique, and it is continuous in G and w. Takes about n steps of
/// O(n^3) each.
/// Source: the active-set method of Stark, Parker 1995, Bounded-variable least-squares. Each step releases the variable
/// whose release decreases the objective fastest.
class BoundedLeastSquares {
public:
    static constexpr std::size_t kMaxNumbers = 6;
    using Numbers = std::array<double, kMaxNumbers>;

    std::size_t count = 0;                        ///< n, number of unknowns
    std::array<Numbers, kMaxNumbers> products{};  ///< [n][n] G
    Numbers wanted{};                             ///< [n] w

    /// Returns the minimum [n]; the remaining entries are 0.
    Numbers minimize() const;

private:
    enum class State { AtZero, Free, AtOne };
    using States = std::array<State, kMaxNumbers>;

    std::optional<std::size_t> to_free(const Numbers& x, const States& states) const;
    Numbers solve(const Numbers& x, const States& states) const;
    bool step(Numbers& x, States& states, const Numbers& to) const;
};

}  // namespace ccdt
