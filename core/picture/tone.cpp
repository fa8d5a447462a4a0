// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/tone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/elementary.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

/// CIE 1976 lightness is linear below this luminance, with the slope kSlope.
constexpr float kLinearBelow = 216.0f / 24389.0f;
constexpr float kSlope = 24389.0f / 2700.0f;

constexpr double kMinInkPerDot = 0.5, kMaxSites = 100'000;

}  // namespace

float lightness(float luminance) {
    return luminance <= kLinearBelow ? luminance * kSlope : 1.16f * elementary::cbrt(luminance) - 0.16f;
}

float lightness_slope(float luminance) {
    if (luminance <= kLinearBelow) return kSlope;
    const float root = elementary::cbrt(luminance);
    return 1.16f / 3 / (root * root);
}

float luminance(float lightness) {
    const float root = (lightness + 0.16f) / 1.16f;
    return lightness <= kLinearBelow * kSlope ? lightness / kSlope : root * root * root;
}

float to_share(float value) {
    return value > 0 ? std::min(value, 1.0f) : 0.0f;
}

std::vector<float> ink_coverage(const Picture& picture, Tone tone, bool invert, Executor& executor) {
    std::vector<float> coverage(picture.luminance.size());
    for_pixels(executor, coverage.size(), [&](std::size_t i) {
        const float luminance = to_share(picture.luminance[i]);
        const float light = tone == Tone::Perceptual ? lightness(luminance) : luminance;
        coverage[i] = std::clamp(invert ? light : 1 - light, 0.0f, 1.0f);
        if (!picture.alpha.empty()) coverage[i] *= to_share(picture.alpha[i]);
    });
    return coverage;
}

std::size_t default_sites(double ink, double fineness, std::size_t limit) {
    constexpr double kInkPerDot = 8;
    // Dots with an area of 8 pixels blur about as much as averaging over 2 x 2 pixels. So dots lose this share of the
    // variance of a picture whose fineness has the same value.
    constexpr double kMaxLost = 0.02;
    constexpr double kMin = 4096;
    const double by_ink = std::min(std::clamp(ink / kInkPerDot, kMin, kMaxSites), ink);
    const double by_detail = std::min({ink / kInkPerDot * fineness / kMaxLost, ink / kMinInkPerDot, kMaxSites});
    const double sites = std::max(by_ink, by_detail);
    return std::clamp(static_cast<std::size_t>(sites), std::size_t{1}, std::max(limit, std::size_t{1}));
}

double radius_of_drawing(double pixels, double fineness, double usual) {
    constexpr double kPixels = 1e6, kMinRadius = 1;
    constexpr double kUsualFineness = 0.06, kMaxFactor = 4;
    const double times = std::clamp(fineness / kUsualFineness, 1.0, kMaxFactor);  // factor on the number of dots
    return std::max(usual * elementary::pow(pixels / kPixels, 0.25) / std::sqrt(times), kMinRadius);
}

std::size_t sites_of_drawing(double ink, double fineness, double scale, double pixels, double usual,
                             std::size_t limit) {
    const double radius = radius_of_drawing(pixels, fineness, usual);
    const double area = std::numbers::pi * radius * radius;
    const double sites = std::min({ink * scale * scale / area, ink / kMinInkPerDot, kMaxSites});
    return std::clamp(static_cast<std::size_t>(sites), std::size_t{1}, std::max(limit, std::size_t{1}));
}

double default_scale(double ink, std::size_t pixels, std::size_t sites) {
    constexpr double kPi = std::numbers::pi;
    constexpr double kRadius = 3;  // canvas pixels; a binary disc of this radius looks round
    const double radius = std::sqrt(ink / (kPi * static_cast<double>(sites)));
    const double wanted = std::max(1.0, std::ceil(kRadius / std::max(radius, 1e-6)));
    const double most = std::sqrt(kMaxCanvasPixels / static_cast<double>(pixels));
    return std::clamp(std::min(wanted, most), 0.1, kLargestScale);
}

}  // namespace ccdt
