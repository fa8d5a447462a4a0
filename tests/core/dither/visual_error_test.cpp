// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/visual_error.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "core/base/random.h"

namespace ccdt {
namespace {

using Error = VisualError<4>;
using Colour = Error::Colour;

constexpr int kWidth = 37, kHeight = 29;

std::vector<Colour> noise() {
    Random random(3, 0);
    std::vector<Colour> residual(kWidth * kHeight);
    for (Colour& colour : residual) {
        for (std::size_t c = 0; c < 3; ++c) colour[c] = static_cast<float>(random.uniform() - 0.5);
    }
    return residual;
}

TEST(VisualError, ChangesLikeAnErrorThatIsComputedAnew) {
    std::vector<Colour> residual = noise();
    Error changed(residual, kWidth, kHeight, kEyeBlur, inline_executor());
    Random random(4, 0);
    for (int i = 0; i < 200; ++i) {
        const int x = static_cast<int>(kWidth * random.uniform()), y = static_cast<int>(kHeight * random.uniform());
        const Colour by{0.3f, -0.2f, static_cast<float>(random.uniform()), 0};
        changed.change(x, y, by);
        for (std::size_t c = 0; c < by.size(); ++c) residual[static_cast<std::size_t>(y * kWidth + x)][c] += by[c];
    }
    const Error expected(residual, kWidth, kHeight, kEyeBlur, inline_executor());
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            for (std::size_t c = 0; c < 4; ++c)
                ASSERT_NEAR(changed.gradient(x, y)[c], expected.gradient(x, y)[c], 2e-5) << x << ' ' << y;
        }
    }
}

TEST(VisualError, HasTheSecondDerivativesThatItStates) {
    Error error(noise(), kWidth, kHeight, kEyeBlur, inline_executor());
    for (const auto& [x, y] : {std::pair{0, 0}, {7, 8}, {15, 16}, {20, 3}, {kWidth - 1, kHeight - 1}}) {
        const Error before = error;
        const Colour by{1, 0.5f, -0.25f, 0};
        error.change(x, y, by);
        for (int dy = -Error::kNear; dy <= Error::kNear; ++dy) {
            for (int dx = -Error::kNear; dx <= Error::kNear; ++dx) {
                if (x + dx < 0 || y + dy < 0 || x + dx >= kWidth || y + dy >= kHeight) continue;
                const float coefficient = dx == 0 && dy == 0 ? error.self() : error.mutual(x, y, dx, dy);
                for (std::size_t c = 0; c < 3; ++c) {
                    const float change = error.gradient(x + dx, y + dy)[c] - before.gradient(x + dx, y + dy)[c];
                    EXPECT_NEAR(change, coefficient * by[c], 1e-5) << x << ' ' << y << ' ' << dx << ' ' << dy;
                }
            }
        }
    }
}

TEST(VisualError, IsZeroWithoutResidual) {
    const Error error(std::vector<Colour>(kWidth * kHeight, Colour{}), kWidth, kHeight, kEyeBlur, inline_executor());
    EXPECT_EQ(error.gradient(5, 5), Colour{});
}

}  // namespace
}  // namespace ccdt
