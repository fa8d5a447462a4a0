// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/bounded_least_squares.h"

#include <numeric>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

using Numbers = BoundedLeastSquares::Numbers;

TEST(BoundedLeastSquares, SolvesOneVariableExactly) {
    for (const auto& [wanted, expected] : {std::pair{-1.0, 0.0}, {0.5, 0.25}, {2.0, 1.0}, {9.0, 1.0}}) {
        BoundedLeastSquares problem;
        problem.count = 1;
        problem.products[0][0] = 2;
        problem.wanted[0] = wanted;
        EXPECT_NEAR(problem.minimize()[0], expected, 1e-12);
    }
}

/// Returns a problem whose matrix G is random of a given rank, plus a small multiple of the identity.
BoundedLeastSquares random_problem(Random& random, std::size_t count, std::size_t rank) {
    BoundedLeastSquares problem;
    problem.count = count;
    std::array<Numbers, BoundedLeastSquares::kMaxNumbers> factors{};
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < rank; ++k) factors[i][k] = 2 * random.uniform() - 1;
    }
    for (std::size_t i = 0; i < count; ++i) {
        problem.wanted[i] = 2 * random.uniform() - 1;
        for (std::size_t k = 0; k < count; ++k) {
            problem.products[i][k] = std::inner_product(factors[i].begin(), factors[i].end(), factors[k].begin(), 0.0);
        }
        problem.products[i][i] += 1e-5;
    }
    return problem;
}

TEST(BoundedLeastSquares, SatisfiesOptimalityConditions) {
    Random random(5, 0);
    for (int trial = 0; trial < 3000; ++trial) {
        const std::size_t count = 1 + static_cast<std::size_t>(trial) % BoundedLeastSquares::kMaxNumbers;
        const BoundedLeastSquares problem = random_problem(random, count, trial % 2 == 0 ? 3 : count);
        const Numbers x = problem.minimize();
        for (std::size_t i = 0; i < count; ++i) {
            const double slope =
                std::inner_product(x.begin(), x.end(), problem.products[i].begin(), 0.0) - problem.wanted[i];
            EXPECT_GE(x[i], 0);
            EXPECT_LE(x[i], 1);
            EXPECT_TRUE(x[i] == 0 || slope < 1e-7) << trial;
            EXPECT_TRUE(x[i] == 1 || slope > -1e-7) << trial;
        }
    }
}

}  // namespace
}  // namespace ccdt
