// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <optional>

namespace ccdt {

/// Minimizes x' G x / 2 - w' x for x in [0, 1]^n, n up to 6.
///
/// By active sets, as in bounded-variable least squares (Stark, Parker 1995): one number after the other is set free
/// from an end of its range where that gains most. G must be positive definite: then the minimum is one, and continuous
/// in G and w. O(n^3) a step, of which there are about n.
class BoundedLeastSquares {
public:
    static constexpr std::size_t kMostNumbers = 6;
    using Numbers = std::array<double, kMostNumbers>;

    std::size_t count = 0;                         ///< n
    std::array<Numbers, kMostNumbers> products{};  ///< G
    Numbers wanted{};                              ///< w

    /// @returns  [n], the rest is 0
    Numbers minimize() const;

private:
    enum class State { AtZero, Free, AtOne };
    using States = std::array<State, kMostNumbers>;

    std::optional<std::size_t> to_free(const Numbers& x, const States& states) const;
    Numbers solve(const Numbers& x, const States& states) const;
    bool step(Numbers& x, States& states, const Numbers& to) const;
};

}  // namespace ccdt
