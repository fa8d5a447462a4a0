// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dot_plan.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "core/halftone/blur.h"
#include "core/halftone/coverage_curve.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/sharpening.h"

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;

/// What is to be covered, sorted by what is to be covered around there.
class Demand {
public:
    void add(const std::vector<float>& cover, const std::vector<float>& around, Executor& executor) {
        if (cover.size() <= kPixelsOfSum) return add(cover, around, 0, cover.size());
        std::vector<Demand> parts((cover.size() + kPixelsOfSum - 1) / kPixelsOfSum);
        for_ranges(executor, cover.size(), kPixelsOfSum, [&](std::size_t begin, std::size_t end) {
            parts[begin / kPixelsOfSum].add(cover, around, begin, end);
        });
        for (const Demand& part : parts) std::ranges::transform(sums_, part.sums_, sums_.begin(), std::plus());
    }

    /// The sum over all that is to be covered of a value that depends on the share around.
    template <class Value>
    double sum(const Value& value) const {
        constexpr double kLeast = 0.25;  // the first bin is of what is next to nothing, but not nothing
        double total = 0;
        for (std::size_t bin = 0; bin < sums_.size(); ++bin) {
            if (sums_[bin] > 0) total += sums_[bin] * value(std::max(static_cast<double>(bin), kLeast) / kBins);
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

/// Discs of one size, how many there are for what is to be covered.
class Discs {
public:
    /// Areas of discs per share to be covered somewhere, by the share around, of which a multiple is wanted.
    double per_share(double around, double factor) const { return curve_.dots(factor * around) / around; }

    /// Areas of all.
    double sum(const Demand& demand, double factor = 1) const {
        return demand.sum([&](double around) { return per_share(around, factor); });
    }

    /// What they cover over what they should.
    double tone(const Demand& demand, double factor) const {
        const auto covered = [&](double around) { return std::min(factor * around, curve_.solid()) / around; };
        return demand.sum(covered) / demand.sum([](double) { return 1; });
    }

private:
    CoverageCurve curve_;
};

/// The multiple of what is to be covered at which the areas of all discs come to a sum.
double find_factor(const Demand& demand, const Discs& discs, double areas) {
    constexpr int kHalvings = 50;
    double low = 1e-9, high = 1e6;
    for (int i = 0; i < kHalvings; ++i) {
        const double factor = std::sqrt(low * high);
        (discs.sum(demand, factor) > areas ? high : low) = factor;
    }
    return std::sqrt(low * high);
}

/// Radius of the surroundings that the same dots cover, in radii of dots. Measured on
/// photographs and textures, by the tone of their levels; 0.6 to 0.9 do.
constexpr double kSurroundings = 0.7;

/// Turns what is to be covered into dots, per pixel. Returns their sum.
/// @param area  of a dot, in pixels
double to_density(std::vector<float>& cover, const std::vector<float>& around, const Discs& discs, double factor,
                  double area, Executor& executor) {
    constexpr double kNothing = 1e-6;
    return sum_of_pixels(executor, cover.size(), [&](std::size_t i) {
        const double share = std::clamp(static_cast<double>(around[i]), kNothing, 1.0);
        cover[i] = static_cast<float>(static_cast<double>(cover[i]) * discs.per_share(share, factor) / area);
        return static_cast<double>(cover[i]);
    });
}

}  // namespace

DotPlan plan_dots(std::vector<std::vector<float>> cover, int width, int height, const DotWish& wish,
                  const std::stop_token& stop, Executor& executor) {
    assert(wish.sites || wish.radius);
    const auto sites = static_cast<double>(wish.sites.value_or(0));
    const Discs discs;
    const auto radius = [&](const Demand& demand) {
        return wish.radius ? *wish.radius : std::sqrt(discs.sum(demand) / (kPi * sites));
    };
    Demand first, demand;
    for (const auto& each : cover) first.add(each, each, executor);
    const double size = radius(first);
    std::vector<std::vector<float>> around;
    for (auto& each : cover) {
        if (stop.stop_requested()) return {};
        each = sharpened(each, width, height, wish.detail * size, executor);
        around.push_back(blurred(each, width, height, kSurroundings * size, executor));
        demand.add(each, around.back(), executor);
    }

    DotPlan plan;
    plan.radius = radius(demand);
    const double area = std::max(kPi * plan.radius * plan.radius, kLeastDotArea);
    const double factor = wish.sites && wish.radius ? find_factor(demand, discs, sites * area) : 1;
    plan.tone = discs.tone(demand, factor);
    for (std::size_t ink = 0; ink < cover.size(); ++ink) {
        plan.dots.push_back(to_density(cover[ink], around[ink], discs, factor, area, executor));
        around[ink] = {};
    }
    plan.density = std::move(cover);
    return plan;
}

}  // namespace ccdt
