// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/sharpening.h"

#include <cstddef>

#include "core/picture/blur.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

constexpr float kNothing = 1e-6F;

/// Returns wanted / made, or 1 if `made` is almost 0.
float ratio(float wanted, float made) {
    return made > kNothing ? wanted / made : 1.0F;
}

}  // namespace

std::vector<float> sharpened(const std::vector<float>& cover, int width, int height, double sigma, Executor& executor) {
    constexpr int kSteps = 2;
    std::vector<float> sharp = cover;
    if (!(sigma > 0)) return sharp;
    std::vector<float> ink(cover.size()), paper(cover.size()), scratch;
    for (int step = 0; step < kSteps; ++step) {
        for_pixels(executor, cover.size(), [&](std::size_t i) { ink[i] = sharp[i]; });
        blur(ink, width, height, sigma, scratch, executor);
        for_pixels(executor, cover.size(), [&](std::size_t i) {
            paper[i] = ratio(1 - cover[i], 1 - ink[i]);
            ink[i] = ratio(cover[i], ink[i]);
        });
        blur(ink, width, height, sigma, scratch, executor);
        blur(paper, width, height, sigma, scratch, executor);
        for_pixels(executor, cover.size(), [&](std::size_t i) {
            const float dark = sharp[i] * ink[i], light = (1 - sharp[i]) * paper[i];
            if (dark + light > kNothing) sharp[i] = dark / (dark + light);
        });
    }
    return sharp;
}

}  // namespace ccdt
