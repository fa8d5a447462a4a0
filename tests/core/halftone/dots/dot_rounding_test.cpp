// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dots/dot_rounding.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/halftone/dots/diffusion.h"

namespace ccdt {
namespace {

using Shares = std::vector<std::uint8_t>;

double sum(const Shares& shares) {
    return std::accumulate(shares.begin(), shares.end(), 0.0);
}

/// The functions that round coverage and keep its sums. The parameter chooses round_dots().
class Rounding : public testing::TestWithParam<bool> {
protected:
    static Shares rounded(Shares shares, int width, int height) {
        GetParam() ? round_dots(shares, width, height) : diffuse(shares, width, height);
        return shares;
    }
};

TEST_P(Rounding, PreservesSum) {
    Random random(1, 0);
    for (const auto& [width, height] : {std::pair{64, 48}, {1, 200}, {200, 1}}) {
        Shares shares(static_cast<std::size_t>(width * height));
        for (auto& share : shares) share = static_cast<std::uint8_t>(256 * random.uniform());
        const Shares result = rounded(shares, width, height);
        for (const auto share : result) ASSERT_TRUE(share == 0 || share == 255);
        EXPECT_NEAR(sum(result), sum(shares), 2 * 255);
    }
}

TEST_P(Rounding, LeavesEmptyAndFullPixelsUnchanged) {
    Random random(2, 0);
    Shares shares(50 * 40);
    for (auto& share : shares) {
        const double kind = random.uniform();
        share = kind < 0.4 ? 0 : kind < 0.7 ? 255 : static_cast<std::uint8_t>(256 * random.uniform());
    }
    const Shares result = rounded(shares, 50, 40);
    for (std::size_t i = 0; i < shares.size(); ++i) {
        if (shares[i] == 0 || shares[i] == 255) {
            EXPECT_EQ(result[i], shares[i]);
        }
    }
    EXPECT_NEAR(sum(result), sum(shares), 2 * 255);
}

TEST_P(Rounding, PassesErrorsOverEmptyAndFullPixels) {
    EXPECT_EQ(rounded({128, 0, 255, 0, 128, 255}, 6, 1), (Shares{255, 0, 255, 0, 0, 255}));
}

INSTANTIATE_TEST_SUITE_P(, Rounding, testing::Bool());

TEST(Diffuse, PreservesLocalSums) {
    constexpr int kSide = 64;
    Shares shares(kSide * kSide);
    for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = static_cast<std::uint8_t>(1 + 3 * (i % kSide));
    Shares result = shares;
    diffuse(result, kSide, kSide);
    for (std::size_t x = 0; x < kSide; x += 8) {
        double wanted = 0, made = 0;
        for (std::size_t i = 0; i < shares.size(); ++i) {
            if (i % kSide / 8 * 8 != x) continue;
            wanted += shares[i];
            made += result[i];
        }
        EXPECT_NEAR(made, wanted, 0.02 * 255 * 8 * kSide) << x;
    }
}

/// Dots at random places within the cells of a square grid.
class Dots {
public:
    static constexpr int kAcross = 12, kCell = 11, kSide = kAcross * kCell;
    static constexpr double kRim = 2;  ///< [pixels] width of the rims, which are not sharp

    /// @param first, last  radius of the dots in the first and the last column
    Dots(double first, double last, bool holes) : shares_(static_cast<std::size_t>(kSide * kSide)) {
        Random random(3, 0);
        for (int dot = 0; dot < kAcross * kAcross; ++dot) {
            const double x = kCell * (dot % kAcross + 0.5) + random.uniform();
            const double y = kCell * (dot / kAcross + 0.5) + random.uniform();
            const double radius = std::lerp(first, last, dot % kAcross / (kAcross - 1.0));
            for (int row = dot / kAcross * kCell; row < (dot / kAcross + 1) * kCell; ++row) {
                for (int column = dot % kAcross * kCell; column < (dot % kAcross + 1) * kCell; ++column) {
                    const double depth = (radius - std::hypot(column + 0.5 - x, row + 0.5 - y)) / kRim;
                    shares_[index(column, row)] = static_cast<std::uint8_t>(255 * std::clamp(0.5 + depth, 0.0, 1.0));
                }
            }
        }
        if (holes) {
            for (auto& share : shares_) share = static_cast<std::uint8_t>(255 - share);
        }
    }

    static std::size_t index(int x, int y) { return static_cast<std::size_t>(y * kSide + x); }

    const Shares& shares() const { return shares_; }

    /// Returns the sum of the shares of a column of dots.
    static double sum_of_column(const Shares& shares, int column) {
        double sum = 0;
        for (int y = 0; y < kSide; ++y) {
            for (int x = column * kCell; x < (column + 1) * kCell; ++x) sum += shares[index(x, y)];
        }
        return sum;
    }

    /// Returns the number of parts of equal pixels, which may touch at corners, within the cell of a dot.
    static int parts(const Shares& shares, std::uint8_t value, int dot) {
        const int left = dot % kAcross * kCell, top = dot / kAcross * kCell;
        std::vector<int> parent(kCell * kCell);
        std::iota(parent.begin(), parent.end(), 0);
        const auto root = [&](int i) {
            while (parent[i] != i) i = parent[i];
            return i;
        };
        const auto is_part = [&](int i) { return shares[index(left + i % kCell, top + i / kCell)] == value; };
        int count = 0;
        for (int i = 0; i < kCell * kCell; ++i) {
            if (!is_part(i)) continue;
            ++count;
            for (const auto& [across, down] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) {
                const int x = i % kCell + across, y = i / kCell + down;
                if (x < 0 || x >= kCell || y < 0 || !is_part(y * kCell + x)) continue;
                if (root(i) == root(y * kCell + x)) continue;
                parent[root(i)] = root(y * kCell + x);
                --count;
            }
        }
        return count;
    }

private:
    Shares shares_;
};

TEST(RoundDots, KeepsDotsAndHolesInOnePiece) {
    for (const bool holes : {false, true}) {
        for (const double radius : {0.3, 0.6, 0.9, 1.3, 2.1, 3.4}) {
            const Dots dots(radius, radius, holes);
            Shares result = dots.shares();
            round_dots(result, Dots::kSide, Dots::kSide);
            for (int dot = 0; dot < Dots::kAcross * Dots::kAcross; ++dot)
                EXPECT_LE(Dots::parts(result, holes ? 0 : 255, dot), 1) << radius << ' ' << holes << ' ' << dot;
            EXPECT_NEAR(sum(result), sum(dots.shares()), 255) << radius << ' ' << holes;
        }
    }
}

TEST(RoundDots, CoversGivenPixels) {
    const Dots few(0.9, 0.9, false), more(2.1, 2.1, false);
    Shares before = few.shares(), result = more.shares();
    round_dots(before, Dots::kSide, Dots::kSide);
    round_dots(result, Dots::kSide, Dots::kSide, before);
    for (std::size_t i = 0; i < result.size(); ++i) EXPECT_GE(result[i], before[i]) << i;
    EXPECT_NEAR(sum(result), sum(more.shares()), 255);
}

TEST(RoundDots, PreservesSumsOfNeighbouringDots) {
    for (const bool holes : {false, true}) {
        const Dots dots(0.3, 3, holes);
        Shares result = dots.shares();
        round_dots(result, Dots::kSide, Dots::kSide);
        for (int column = 0; column < Dots::kAcross; ++column)
            EXPECT_NEAR(Dots::sum_of_column(result, column), Dots::sum_of_column(dots.shares(), column), 4 * 255);
    }
}

}  // namespace
}  // namespace ccdt
