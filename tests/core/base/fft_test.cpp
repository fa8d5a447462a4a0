// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/fft.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/thread_executor.h"

#include "core/base/random.h"

namespace ccdt {
namespace {

using Complex = std::complex<double>;

constexpr double kPi = std::numbers::pi;

/// Even and odd, prime and composite, one-dimensional and single-cell sizes.
constexpr std::pair<int, int> kSizes[] = {{12, 10}, {9, 16}, {7, 13}, {1, 6}, {6, 1}, {1, 1}};

std::vector<double> noise(std::size_t size) {
    Random random(1, 0);
    std::vector<double> values(size);
    for (double& value : values) value = random.uniform() - 0.5;
    return values;
}

/// Returns a number divided by all its factors 2, 3 and 5.
int rough_part(int number) {
    for (const int prime : {2, 3, 5}) {
        while (number % prime == 0) number /= prime;
    }
    return number;
}

TEST(GoodSize, IsTheSmallestEvenProductOfSmallPrimes) {
    int expected = 2;
    for (int least = 1; least <= 3000; ++least) {
        while (expected < least || expected % 2 != 0 || rough_part(expected) != 1) ++expected;
        ASSERT_EQ(good_size(least), expected);
    }
}

TEST(GoodSize, RoundsUp) {
    EXPECT_EQ(good_size(0), 2);
    EXPECT_EQ(good_size(-3), 2);
    EXPECT_EQ(good_size(10), 10);
    EXPECT_EQ(good_size(10.001), 12);
    EXPECT_EQ(good_size(1e9), 1'000'000'000);
}

TEST(RealTransform, StartsWithZeros) {
    RealTransform transform({6, 4, 1});
    EXPECT_EQ(transform.grid().size(), 24u);
    EXPECT_EQ(transform.spectrum().size(), 16u);
    for (const double value : transform.grid()) EXPECT_EQ(value, 0);
    for (const Complex value : transform.spectrum()) EXPECT_EQ(value, Complex());
}

TEST(RealTransform, TransformsAnImpulseToAWave) {
    for (const auto& [columns, rows] : kSizes) {
        const int x = columns / 3, y = rows / 2;
        RealTransform transform({columns, rows, 1});
        transform.grid()[static_cast<std::size_t>(y * columns + x)] = 1;
        transform.forward();
        const int width = columns / 2 + 1;
        for (int v = 0; v < rows; ++v) {
            for (int u = 0; u < width; ++u) {
                const Complex expected = std::polar(1.0, -2 * kPi * (double(u) * x / columns + double(v) * y / rows));
                EXPECT_LT(std::abs(transform.spectrum()[static_cast<std::size_t>(v * width + u)] - expected), 1e-14)
                    << columns << " x " << rows << " at " << u << ", " << v;
            }
        }
    }
}

TEST(RealTransform, FindsASingleWave) {
    constexpr int kColumns = 12, kRows = 10, kU = 3, kV = 2;
    RealTransform transform({kColumns, kRows, 1});
    for (int y = 0; y < kRows; ++y) {
        for (int x = 0; x < kColumns; ++x) {
            transform.grid()[static_cast<std::size_t>(y * kColumns + x)] =
                std::cos(2 * kPi * (double(kU) * x / kColumns + double(kV) * y / kRows) + 0.5);
        }
    }
    transform.forward();
    for (int v = 0; v < kRows; ++v) {
        for (int u = 0; u <= kColumns / 2; ++u) {
            const Complex expected = u == kU && v == kV ? std::polar(kColumns * kRows / 2.0, 0.5) : Complex();
            EXPECT_LT(std::abs(transform.spectrum()[static_cast<std::size_t>(v * (kColumns / 2 + 1) + u)] - expected),
                      1e-12)
                << u << ", " << v;
        }
    }
}

TEST(RealTransform, RoundTripsUpToTheNumberOfCells) {
    for (const auto& [columns, rows] : kSizes) {
        RealTransform transform({columns, rows, 1});
        const auto values = noise(transform.grid().size());
        std::ranges::copy(values, transform.grid().begin());
        transform.forward();
        transform.backward();
        for (std::size_t i = 0; i < values.size(); ++i) {
            EXPECT_NEAR(transform.grid()[i] / (columns * rows), values[i], 1e-14) << columns << " x " << rows;
        }
    }
}

TEST(RealTransform, KeepsTheGridInTheForwardTransform) {
    RealTransform transform({12, 10, 1});
    const auto values = noise(120);
    std::ranges::copy(values, transform.grid().begin());
    transform.forward();
    EXPECT_TRUE(std::ranges::equal(transform.grid(), values));
}

TEST(RealTransform, KeepsItsContentsWhenMoved) {
    RealTransform first({4, 4, 1});
    first.grid()[0] = 3;
    RealTransform second(std::move(first));
    first = RealTransform({2, 2, 1});
    second.forward();
    EXPECT_EQ(second.spectrum()[5], Complex(3));
    EXPECT_EQ(first.grid().size(), 4u);
}

TEST(RealTransform, IsClearedByARelease) {
    const auto values = noise(120);
    const auto rests = [&](auto&& transform) {
        std::ranges::copy(values, transform.grid().begin());
        transform.forward();
        transform.release_memory();
        for (const double value : transform.grid()) EXPECT_EQ(value, 0);
        std::ranges::copy(values, transform.grid().begin());
        transform.forward();
        transform.backward();
        return transform.grid()[17];
    };
    EXPECT_NEAR(rests(RealTransform({12, 10, 1})) / 120, values[17], 1e-14);
    EXPECT_NEAR(rests(CosineTransform({12, 10, 1})) / 480, values[17], 1e-14);
}

TEST(RealTransform, IsThreadSafe) {
    constexpr int kSide = 90;
    const auto values = noise(kSide * kSide);
    const auto transformed = [&] {
        RealTransform transform({kSide, kSide, 1});
        std::ranges::copy(values, transform.grid().begin());
        transform.forward();
        return std::vector<Complex>(transform.spectrum().begin(), transform.spectrum().end());
    };
    const auto expected = transformed();
    std::vector<std::vector<Complex>> found(4);
    {
        std::vector<std::jthread> threads;
        for (auto& result : found) threads.emplace_back([&] { result = transformed(); });
    }
    for (const auto& result : found) EXPECT_EQ(result, expected);
}

TEST(RealTransform, IsIdenticalOnAnyNumberOfThreads) {
    const auto values = noise(90 * 100);
    const auto there_and_back = [&](auto&& transform) {
        std::ranges::copy(values, transform.grid().begin());
        transform.forward();
        std::vector<double> found(transform.grid().begin(), transform.grid().end());
        transform.backward();
        found.insert(found.end(), transform.grid().begin(), transform.grid().end());
        return found;
    };
    for (const std::size_t size : {2, 3, 16}) {
        ThreadExecutor executor(size);
        EXPECT_EQ(there_and_back(RealTransform({90, 100, 1}, executor)), there_and_back(RealTransform({90, 100, 1})));
        EXPECT_EQ(there_and_back(CosineTransform({90, 100, 1}, executor)),
                  there_and_back(CosineTransform({90, 100, 1})));
    }
}

TEST(CosineTransform, FindsASingleWave) {
    for (const auto& [columns, rows] : kSizes) {
        const int u = columns / 2, v = rows / 3;
        CosineTransform transform({columns, rows, 1});
        for (int y = 0; y < rows; ++y) {
            for (int x = 0; x < columns; ++x) {
                transform.grid()[static_cast<std::size_t>(y * columns + x)] =
                    std::cos(kPi * u * (x + 0.5) / columns) * std::cos(kPi * v * (y + 0.5) / rows);
            }
        }
        transform.forward();
        // The mean square of a cosine is a half, except for the constant.
        const double expected = columns * rows * (u == 0 ? 2.0 : 1.0) * (v == 0 ? 2.0 : 1.0);
        for (int y = 0; y < rows; ++y) {
            for (int x = 0; x < columns; ++x) {
                EXPECT_NEAR(transform.grid()[static_cast<std::size_t>(y * columns + x)],
                            x == u && y == v ? expected : 0, 1e-12)
                    << columns << " x " << rows << " at " << x << ", " << y;
            }
        }
    }
}

TEST(CosineTransform, TransformsAnImpulseToAWave) {
    constexpr int kColumns = 8, kRows = 5, kX = 3, kY = 4;
    CosineTransform transform({kColumns, kRows, 1});
    transform.grid()[kY * kColumns + kX] = 1;
    transform.forward();
    for (int v = 0; v < kRows; ++v) {
        for (int u = 0; u < kColumns; ++u) {
            EXPECT_NEAR(transform.grid()[static_cast<std::size_t>(v * kColumns + u)],
                        4 * std::cos(kPi * u * (kX + 0.5) / kColumns) * std::cos(kPi * v * (kY + 0.5) / kRows), 1e-13);
        }
    }
}

TEST(CosineTransform, RoundTripsUpToFourTimesTheNumberOfCells) {
    for (const auto& [columns, rows] : kSizes) {
        CosineTransform transform({columns, rows, 1});
        const auto values = noise(transform.grid().size());
        std::ranges::copy(values, transform.grid().begin());
        transform.forward();
        transform.backward();
        for (std::size_t i = 0; i < values.size(); ++i) {
            EXPECT_NEAR(transform.grid()[i] / (4 * columns * rows), values[i], 1e-14) << columns << " x " << rows;
        }
    }
}

TEST(RealTransform, TransformsAnImpulseInSpaceToAWave) {
    for (const std::array<int, 3>& cells : {std::array{6, 5, 4}, std::array{1, 2, 3}, std::array{5, 1, 2}}) {
        const auto [columns, rows, layers] = cells;
        const int x = columns / 3, y = rows / 2, z = layers - 1;
        RealTransform transform(cells, inline_executor());
        transform.grid()[static_cast<std::size_t>((z * rows + y) * columns + x)] = 1;
        transform.forward();
        const int width = columns / 2 + 1;
        for (int w = 0; w < layers; ++w) {
            for (int v = 0; v < rows; ++v) {
                for (int u = 0; u < width; ++u) {
                    const double turns = double(u) * x / columns + double(v) * y / rows + double(w) * z / layers;
                    const auto number = static_cast<std::size_t>((w * rows + v) * width + u);
                    EXPECT_LT(std::abs(transform.spectrum()[number] - std::polar(1.0, -2 * kPi * turns)), 1e-14);
                }
            }
        }
        transform.backward();
        const auto impulse = static_cast<std::size_t>((z * rows + y) * columns + x);
        for (std::size_t i = 0; i < transform.grid().size(); ++i)
            EXPECT_NEAR(transform.grid()[i], i == impulse ? columns * rows * layers : 0, 1e-12);
    }
}

TEST(CosineTransform, TransformsAnImpulseInSpaceToAProductOfCosines) {
    constexpr int kColumns = 6, kRows = 5, kLayers = 4, kX = 4, kY = 0, kZ = 2;
    CosineTransform transform({kColumns, kRows, kLayers}, inline_executor());
    constexpr std::size_t kImpulse = (kZ * kRows + kY) * kColumns + kX;
    transform.grid()[kImpulse] = 1;
    transform.forward();
    const auto cosine = [](int k, int position, int cells) { return 2 * std::cos(kPi * k * (position + 0.5) / cells); };
    for (int w = 0; w < kLayers; ++w) {
        for (int v = 0; v < kRows; ++v) {
            for (int u = 0; u < kColumns; ++u) {
                EXPECT_NEAR(transform.grid()[static_cast<std::size_t>((w * kRows + v) * kColumns + u)],
                            cosine(u, kX, kColumns) * cosine(v, kY, kRows) * cosine(w, kZ, kLayers), 1e-14);
            }
        }
    }
    transform.backward();
    for (std::size_t i = 0; i < transform.grid().size(); ++i)
        EXPECT_NEAR(transform.grid()[i], i == kImpulse ? 8 * kColumns * kRows * kLayers : 0, 1e-12);
}

}  // namespace
}  // namespace ccdt
