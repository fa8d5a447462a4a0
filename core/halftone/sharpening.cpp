#include "core/halftone/sharpening.h"

#include <cstddef>

#include "core/halftone/blur.h"

namespace ccdt {

namespace {

constexpr float kNothing = 1e-6F;

/// What there is over what there would be; 1 where that is next to nothing.
float ratio(float wanted, float made) {
    return made > kNothing ? wanted / made : 1.0F;
}

}  // namespace

std::vector<float> sharpened(std::vector<float> cover, int width, int height, double sigma) {
    constexpr int kSteps = 2;
    if (!(sigma > 0)) return cover;
    std::vector<float> sharp = cover;
    for (int step = 0; step < kSteps; ++step) {
        std::vector<float> ink = blurred(sharp, width, height, sigma), paper(ink.size());
        for (std::size_t i = 0; i < cover.size(); ++i) {
            paper[i] = ratio(1 - cover[i], 1 - ink[i]);
            ink[i] = ratio(cover[i], ink[i]);
        }
        ink = blurred(ink, width, height, sigma);
        paper = blurred(paper, width, height, sigma);
        for (std::size_t i = 0; i < cover.size(); ++i) {
            const float dark = sharp[i] * ink[i], light = (1 - sharp[i]) * paper[i];
            if (dark + light > kNothing) sharp[i] = dark / (dark + light);
        }
    }
    return sharp;
}

}  // namespace ccdt
