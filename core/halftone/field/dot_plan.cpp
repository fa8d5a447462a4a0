// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/dot_plan.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "core/halftone/inks/coverage_curve.h"
#include "core/picture/blur.h"
#include "core/picture/pixel_ranges.h"
#include "core/picture/sharpening.h"
#include "core/picture/tone.h"

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;

/// Histogram of the mean coverage around each pixel, weighted by the wanted coverage of the pixel.
class CoverageHistogram {
public:
    void add(const std::vector<float>& cover, const std::vector<float>& around, Executor& executor) {
        if (cover.size() <= kPixelsOfSum) return add(cover, around, 0, cover.size());
        std::vector<CoverageHistogram> parts((cover.size() + kPixelsOfSum - 1) / kPixelsOfSum);
        for_ranges(executor, cover.size(), kPixelsOfSum, [&](std::size_t begin, std::size_t end) {
            parts[begin / kPixelsOfSum].add(cover, around, begin, end);
        });
        for (const CoverageHistogram& part : parts)
            std::ranges::transform(sums_, part.sums_, sums_.begin(), std::plus());
    }

    /// Returns the sum of cover * value(around) over all pixels, where `around` is the mean coverage around the pixel.
    template <class Value>
    double sum(const Value& value) const {
        constexpr double kFirstBin = 0.25;  // in bins; the first bin holds coverages that are small but not 0
        double total = 0;
        for (std::size_t bin = 0; bin < sums_.size(); ++bin) {
            if (sums_[bin] > 0) total += sums_[bin] * value(std::max(static_cast<double>(bin), kFirstBin) / kBins);
        }
        return total;
    }

private:
    static constexpr int kBins = 2048;

    void add(const std::vector<float>& cover, const std::vector<float>& around, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const float bin = std::clamp(around[i], 0.0f, 1.0f) * kBins;
            sums_[static_cast<std::size_t>(bin + 0.5f)] += static_cast<double>(cover[i]);
        }
    }

    std::array<double, kBins + 1> sums_{};
};

/// Computes the total area of the equal discs that produce a wanted coverage. An overlap counts once for each of its
/// marks. For a line, squares of its width take the place of marks.
class MarkArea {
public:
    explicit MarkArea(Mark mark) : curve_(mark), unit_(mark == Mark::Disc ? kPi : 4) {}

    /// Returns the area of a disc of a radius, or the square of the width of a line.
    double of(double radius) const { return unit_ * radius * radius; }

    /// Returns the radius at which some marks have a total area.
    double radius(double area, double marks) const { return std::sqrt(area / (unit_ * marks)); }

    /// Returns the total disc area that is needed, divided by the wanted coverage.
    /// @param around  mean wanted coverage around the pixel, > 0
    /// @param factor  factor by which the wanted coverage is multiplied
    double per_cover(double around, double factor) const { return curve_.dots(factor * around) / around; }

    /// Returns the total disc area of a picture, in pixels.
    double sum(const CoverageHistogram& cover, double factor = 1) const {
        return cover.sum([&](double around) { return per_cover(around, factor); });
    }

    /// Returns the area that the discs cover, divided by the area that they should cover. Overlaps count once.
    double tone(const CoverageHistogram& cover, double factor) const {
        const auto covered = [&](double around) { return std::min(factor * around, curve_.solid()) / around; };
        return cover.sum(covered) / cover.sum([](double) { return 1; });
    }

private:
    CoverageCurve curve_;
    double unit_;
};

/// Returns the factor by which the wanted coverage has to be multiplied so that the total disc area is `area`.
double find_factor(const CoverageHistogram& cover, const MarkArea& marks, double area) {
    constexpr int kHalvings = 50;
    double low = 1e-9, high = 1e6;
    for (int i = 0; i < kHalvings; ++i) {
        const double factor = std::sqrt(low * high);
        (marks.sum(cover, factor) > area ? high : low) = factor;
    }
    return std::sqrt(low * high);
}

/// Standard deviation, in radii of dots, of the blur that gives the mean coverage around a pixel. Chosen by
/// the error of the mean tone at each grey level of photographs and textures. Values from 0.6 to 0.9 are equally good.
constexpr double kSurroundings = 0.7;

/// Converts the wanted coverage of each pixel to the number of dots per pixel. Returns the sum of these numbers.
/// @param area  area of a dot, in pixels
double to_density(std::vector<float>& cover, const std::vector<float>& around, const MarkArea& marks, double factor,
                  double area, Executor& executor) {
    constexpr double kNothing = 1e-6;
    return sum_of_pixels(executor, cover.size(), [&](std::size_t i) {
        const double share = std::clamp(static_cast<double>(around[i]), kNothing, 1.0);
        cover[i] = static_cast<float>(static_cast<double>(cover[i]) * marks.per_cover(share, factor) / area);
        return static_cast<double>(cover[i]);
    });
}

/// Converts the wanted coverage of each pixel to the number of dots per pixel that shows local contrast.
/// @param tone   share of the tone that all dots can cover, < 1/2
/// @param sites  number of dots
/// @param area   area of a dot, in pixels
void to_contrast(std::vector<float>& cover, int width, int height, double tone, double sites, double area,
                 Executor& executor) {
    constexpr double kSurroundingsOfSide = 0.04, kMaxCover = 0.75;
    constexpr float kMin = 0.04f;
    constexpr int kRounds = 12;
    for_pixels(executor, cover.size(), [&](std::size_t i) { cover[i] = 1 - lightness(1 - to_share(cover[i])); });
    const auto around = blurred(cover, width, height, kSurroundingsOfSide * std::max(width, height), executor);
    const auto part = static_cast<float>(0.9 * (1 - 2 * tone));
    for_pixels(executor, cover.size(),
               [&](std::size_t i) { cover[i] = std::max(cover[i] - part * around[i], kMin * cover[i]); });
    const auto most = static_cast<float>(kMaxCover / area);
    double scale = 1;
    const auto dots = [&](std::size_t i) {
        return std::min(static_cast<double>(cover[i]) * scale, static_cast<double>(most));
    };
    for (int round = 0; round < kRounds; ++round) {
        const double sum = sum_of_pixels(executor, cover.size(), dots);
        if (!(sum > 0)) break;
        scale *= sites / sum;
    }
    for_pixels(executor, cover.size(), [&](std::size_t i) { cover[i] = static_cast<float>(dots(i)); });
}

}  // namespace

DotPlan plan_dots(std::vector<std::vector<float>> cover, int width, int height, const DotRequest& request,
                  const std::stop_token& stop, Executor& executor) {
    constexpr double kMinTone = 0.5;
    assert(request.sites || request.radius);
    const auto sites = static_cast<double>(request.sites.value_or(0));
    const MarkArea marks(request.mark);
    const auto radius = [&](const CoverageHistogram& histogram) {
        return request.radius ? *request.radius : marks.radius(marks.sum(histogram), sites);
    };
    CoverageHistogram first, histogram;
    for (const auto& each : cover) first.add(each, each, executor);
    const double size = radius(first);
    std::vector<std::vector<float>> around;
    for (auto& each : cover) {
        if (stop.stop_requested()) return {};
        each = sharpened(each, width, height, request.detail * size, executor);
        around.push_back(blurred(each, width, height, kSurroundings * size, executor));
        histogram.add(each, around.back(), executor);
    }

    DotPlan plan;
    plan.radius = radius(histogram);
    const double area = std::max(marks.of(plan.radius), kMinDotArea);
    const double factor = request.sites && request.radius ? find_factor(histogram, marks, sites * area) : 1;
    plan.tone = marks.tone(histogram, factor);
    plan.shows_contrast = request.may_show_contrast && request.sites && request.radius && plan.tone < kMinTone;
    for (std::size_t ink = 0; ink < cover.size(); ++ink) {
        const std::vector<float> own = plan.shows_contrast ? cover[ink] : std::vector<float>{};
        plan.dots.push_back(to_density(cover[ink], around[ink], marks, factor, area, executor));
        around[ink] = {};
        if (!plan.shows_contrast) continue;
        cover[ink] = own;
        to_contrast(cover[ink], width, height, plan.tone, plan.dots.back(), area, executor);
    }
    plan.density = std::move(cover);
    return plan;
}

}  // namespace ccdt
