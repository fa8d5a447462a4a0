#include "core/halftone/box_programme.h"

#include <numeric>

#include <gtest/gtest.h>

#include "core/random.h"

namespace ccdt {
namespace {

using Numbers = BoxProgramme::Numbers;

TEST(BoxProgramme, SolvesOneNumberInClosedForm) {
    for (const auto& [wanted, expected] : {std::pair{-1.0, 0.0}, {0.5, 0.25}, {2.0, 1.0}, {9.0, 1.0}}) {
        BoxProgramme programme;
        programme.count = 1;
        programme.products[0][0] = 2;
        programme.wanted[0] = wanted;
        EXPECT_NEAR(programme.minimize()[0], expected, 1e-12);
    }
}

/// A random G of full rank or, but for a ridge, of rank 3.
BoxProgramme random_programme(Random& random, std::size_t count, std::size_t rank) {
    BoxProgramme programme;
    programme.count = count;
    std::array<Numbers, BoxProgramme::kMostNumbers> factors{};
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < rank; ++k) factors[i][k] = 2 * random.uniform() - 1;
    }
    for (std::size_t i = 0; i < count; ++i) {
        programme.wanted[i] = 2 * random.uniform() - 1;
        for (std::size_t k = 0; k < count; ++k) {
            programme.products[i][k] =
                std::inner_product(factors[i].begin(), factors[i].end(), factors[k].begin(), 0.0);
        }
        programme.products[i][i] += 1e-5;
    }
    return programme;
}

TEST(BoxProgramme, EndsWhereNothingIsGained) {
    Random random(5, 0);
    for (int trial = 0; trial < 3000; ++trial) {
        const std::size_t count = 1 + static_cast<std::size_t>(trial) % BoxProgramme::kMostNumbers;
        const BoxProgramme programme = random_programme(random, count, trial % 2 == 0 ? 3 : count);
        const Numbers x = programme.minimize();
        for (std::size_t i = 0; i < count; ++i) {
            const double slope =
                std::inner_product(x.begin(), x.end(), programme.products[i].begin(), 0.0) - programme.wanted[i];
            EXPECT_GE(x[i], 0);
            EXPECT_LE(x[i], 1);
            EXPECT_TRUE(x[i] == 0 || slope < 1e-7) << trial;
            EXPECT_TRUE(x[i] == 1 || slope > -1e-7) << trial;
        }
    }
}

}  // namespace
}  // namespace ccdt
