// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/field_plan.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/base/elementary.h"
#include "core/halftone/field/dot_plan.h"
#include "core/halftone/inks/ink_mixture.h"
#include "core/picture/blur.h"
#include "core/picture/colour_difference.h"
#include "core/picture/pixel_ranges.h"
#include "core/picture/srgb.h"
#include "core/picture/tone.h"
#include "core/picture/total_variation.h"

namespace ccdt {

namespace {

/// Returns the length of the gradient of an image, per cell.
std::vector<float> gradients(const std::vector<float>& values, const CellGrid& cells, Executor& executor) {
    const auto columns = static_cast<std::size_t>(cells.columns), rows = static_cast<std::size_t>(cells.rows);
    std::vector<float> lengths(values.size());
    for_rows(executor, cells.columns, rows, [&](std::size_t y) {
        const std::size_t up = y > 0 ? y - 1 : y, down = std::min(y + 1, rows - 1);
        for (std::size_t x = 0; x < columns; ++x) {
            const std::size_t left = x > 0 ? x - 1 : x, right = std::min(x + 1, columns - 1);
            const float across = (values[y * columns + right] - values[y * columns + left]) /
                                 static_cast<float>(std::max<std::size_t>(right - left, 1));
            const float along = (values[down * columns + x] - values[up * columns + x]) /
                                static_cast<float>(std::max<std::size_t>(down - up, 1));
            lengths[y * columns + x] = std::sqrt(across * across + along * along);
        }
    });
    return lengths;
}

/// Returns the factor by which contrasts grow at edges, so that they are drawn as edges and not as dots.
/// @param light  denoised
/// @param pitch  in cells
std::vector<float> steepness_of(const std::vector<float>& light, const CellGrid& cells, double pitch,
                                Executor& executor) {
    constexpr double kBlur = 0.6;
    constexpr float kEdge = 0.3f, kGain = 4, kMax = 12;
    auto factors = gradients(blurred(light, cells.columns, cells.rows, kBlur, executor), cells, executor);
    for_pixels(executor, factors.size(), [&](std::size_t i) {
        const float excess = std::max(factors[i] * static_cast<float>(pitch) - kEdge, 0.0f);
        factors[i] = std::min(1 + kGain * excess * excess, kMax);
    });
    return factors;
}

/// Finds the extremes of a channel in the three by three cells around each cell.
void find_extremes(FieldChannel& channel, const CellGrid& cells, Executor& executor) {
    const auto columns = static_cast<std::size_t>(cells.columns), rows = static_cast<std::size_t>(cells.rows);
    channel.low.resize(channel.sharp.size());
    channel.high.resize(channel.sharp.size());
    for_ranges(executor, rows, rows_of_task(cells.columns), [&](std::size_t begin, std::size_t end) {
        std::vector<float> least(columns), most(columns);
        for (std::size_t y = begin; y < end; ++y) {
            const auto row = [&](std::size_t number) { return channel.sharp.data() + number * columns; };
            const float *upper = row(y > 0 ? y - 1 : y), *middle = row(y), *lower = row(std::min(y + 1, rows - 1));
            for (std::size_t x = 0; x < columns; ++x) {
                least[x] = std::min(std::min(upper[x], middle[x]), lower[x]);
                most[x] = std::max(std::max(upper[x], middle[x]), lower[x]);
            }
            for (std::size_t x = 0; x < columns; ++x) {
                const std::size_t left = x > 0 ? x - 1 : x, right = std::min(x + 1, columns - 1);
                channel.low[y * columns + x] = std::min(std::min(least[left], least[x]), least[right]);
                channel.high[y * columns + x] = std::max(std::max(most[left], most[x]), most[right]);
            }
        }
    });
}

/// Computes the luminance of a picture from its channels: the luminance of the darkest colour, and the luminance that
/// each channel adds.
struct Luminance {
    float dark = 0;
    std::vector<float> steps;  ///< [channels]
};

/// Density of sites and the share of dots or holes at a cell.
struct CellDensity {
    float density;  ///< up to a factor
    float share;
    bool has_holes;  ///< two for each site
};

/// @param luminance  in [0, 1]
/// @param share      of dots or holes
CellDensity density_of(float luminance, float share) {
    constexpr float kMu = 0.05f, kShadow = 0.35f, kHighlight = 0.65f, kShare = 0.6f;
    const float tone = std::clamp((luminance - kShadow) / (kHighlight - kShadow), 0.0f, 1.0f);
    return {elementary::log1p(share * lightness_slope(luminance) / kMu) * (kShare + (1 - kShare) * tone), share,
            luminance < 0.5f};
}

/// Prepares the channels of a drawing.
class FieldPlanner {
public:
    /// @param smooth  [channels] denoised light
    FieldPlanner(const CellGrid& cells, std::vector<std::vector<float>> light, std::vector<std::vector<float>> smooth,
                 Luminance luminance, const FieldOptions& options, Executor& executor)
        : luminance_(std::move(luminance)), options_(options), executor_(executor) {
        plan_.cells = cells;
        for (std::size_t c = 0; c < light.size(); ++c)
            plan_.channels.push_back({std::move(light[c]), std::move(smooth[c]), {}, {}, {}});
    }

    /// Plans boundaries between sets of inks.
    /// @param picture  denoised light
    FieldPlan plan(std::vector<unsigned> sets, const LightPlanes& picture) {
        plan_.sets = std::move(sets);
        picture_ = &picture;
        return plan();
    }

    FieldPlan plan() {
        if (!has_dots()) {
            keep_edges();
            return std::move(plan_);
        }
        choose_sites();
        const double pitch = plan_.pitch();
        find_steepness(pitch);
        for (FieldChannel& channel : plan_.channels) find_extremes(channel, plan_.cells, executor_);
        find_density(options_.least_area);
        plan_.is_limited = options_.least_area > 0;
        if (plan_.is_limited) limit_density();
        for (FieldChannel& channel : plan_.channels) {
            sharpen(channel, pitch);
            find_extremes(channel, plan_.cells, executor_);
        }
        return std::move(plan_);
    }

private:
    std::size_t size() const { return plan_.channels.front().sharp.size(); }

    /// Finds the edges of each channel or, for sets of inks, of the picture: their shares change much where colours
    /// change little.
    void find_steepness(double pitch) {
        if (picture_ == nullptr) {
            for (FieldChannel& channel : plan_.channels)
                channel.steepness = steepness_of(channel.sharp, plan_.cells, pitch, executor_);
            return;
        }
        std::vector<float> largest(size(), 1);
        for (const std::vector<float>& plane : *picture_) {
            const auto own = steepness_of(plane, plan_.cells, pitch, executor_);
            for_pixels(executor_, size(), [&](std::size_t i) { largest[i] = std::max(largest[i], own[i]); });
        }
        for (FieldChannel& channel : plan_.channels) channel.steepness = largest;
    }

    /// Returns whether any part of the picture is neither bare paper nor solid ink.
    bool has_dots() const {
        return std::ranges::any_of(plan_.channels, [](const FieldChannel& channel) {
            return std::ranges::any_of(channel.light, [](float light) { return light > 0 && light < 1; });
        });
    }

    /// Prepares a picture without dots, whose edges stay where they are.
    void keep_edges() {
        constexpr float kSteepness = 12;
        for (FieldChannel& channel : plan_.channels) {
            channel.sharp = channel.light;
            channel.steepness.assign(channel.light.size(), kSteepness);
            find_extremes(channel, plan_.cells, executor_);
        }
        plan_.density.assign(size(), 0.0f);
    }

    /// Determines the number of sites and the radius of the largest dots, those at the luminance 1/2.
    void choose_sites() {
        find_density(0);
        const double dots =
            0.5 * sum_of(executor_, plan_.density) / static_cast<double>(density_of(0.5f, 0.5f).density);
        if (options_.sites) {
            plan_.sites = static_cast<double>(*options_.sites);
        } else {
            plan_.sites = dots / std::max(std::numbers::pi * *options_.radius * *options_.radius, kMinDotArea);
            if (options_.max_sites) plan_.sites = std::min(plan_.sites, static_cast<double>(*options_.max_sites));
        }
        plan_.radius = std::sqrt(dots / (std::numbers::pi * std::max(plan_.sites, 1.0)));
    }

    CellDensity at(std::size_t cell) const {
        constexpr float kLargest = 0.5f;
        float luminance = luminance_.dark, mean = 0, largest = 0;
        for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
            const FieldChannel& channel = plan_.channels[c];
            const float light = channel.sharp[cell];
            const bool is_flat = channel.steepness.empty();
            const float steep = std::clamp(
                is_flat ? light : steepened(light, channel.steepness[cell], channel.low[cell], channel.high[cell]),
                0.0f, 1.0f);
            const float share = std::min(steep, 1 - steep);
            luminance += luminance_.steps[c] * light;
            mean += luminance_.steps[c] * share;
            largest = std::max(largest, share);
        }
        return density_of(std::clamp(luminance, 0.0f, 1.0f), std::max(mean, kLargest * largest));
    }

    /// @param least_area  smallest area of a dot, which limits the number of sites in a cell
    void find_density(double least_area) {
        plan_.density.resize(size());
        most_.resize(size());
        for_pixels(executor_, size(), [&](std::size_t i) {
            const CellDensity cell = at(i);
            plan_.density[i] = cell.density;
            most_[i] = cell.share / (static_cast<float>(least_area) * (cell.has_holes ? 2 : 1));
        });
    }

    /// Moves sites away from cells whose dots or holes would be smaller than allowed.
    void limit_density() {
        constexpr int kRounds = 6;
        constexpr double kMax = 4, kTiny = 1e-30;
        const std::vector<float> free = plan_.density;
        double scale = plan_.sites / std::max(sum_of(executor_, free), kTiny);
        for (int round = 0; round < kRounds; ++round) {
            for_pixels(executor_, free.size(), [&](std::size_t i) {
                plan_.density[i] = std::min(free[i] * static_cast<float>(scale), most_[i]);
            });
            scale *= std::min(plan_.sites / std::max(sum_of(executor_, plan_.density), kTiny), kMax);
        }
    }

    void sharpen(FieldChannel& channel, double pitch) const {
        constexpr double kSurroundings = 0.6, kEmphasis = 0.8;
        const auto gain = static_cast<float>(kEmphasis * options_.detail);
        const auto around =
            blurred(channel.sharp, plan_.cells.columns, plan_.cells.rows, kSurroundings * pitch, executor_);
        for_pixels(executor_, around.size(),
                   [&](std::size_t i) { channel.sharp[i] += gain * (channel.sharp[i] - around[i]); });
    }

    Luminance luminance_;
    const FieldOptions& options_;
    Executor& executor_;
    FieldPlan plan_;
    const LightPlanes* picture_ = nullptr;  ///< null: channels are those of the picture
    std::vector<float> most_;               ///< [cells] largest number of sites
};

std::vector<float> smoothed(const std::vector<float>& light, const CellGrid& cells, Executor& executor) {
    constexpr float kDenoising = 0.03f;
    constexpr int kSteps = 15;
    return denoised(light, cells.columns, cells.rows, kDenoising, kSteps, executor);
}

/// Chooses sets of inks that reproduce the colours of a picture. Starts with the darkest and the lightest set, and adds
/// the set that brings the mixtures nearest to those of all sets, until there are enough.
/// @returns  from dark to light
std::vector<unsigned> useful_sets(const LightPlanes& light, const InkSet& inks, const CellGrid& cells,
                                  Executor& executor) {
    constexpr int kSide = 30;
    constexpr double kNegligible = 0.1, kMinGain = 1e-3;  // lightness, and its mean square
    const std::vector<unsigned> all = sets_by_luminance(inks);

    const CellGrid few{std::min(cells.columns, kSide), std::min(cells.rows, kSide)};
    LightPlanes small;
    for (std::size_t c = 0; c < small.size(); ++c)
        small[c] = reduced(light[c], cells.columns, cells.rows, few, executor);
    std::vector<Light> means;
    for (std::size_t i = 0; i < small.front().size(); ++i) means.push_back(light_at(small, i));
    const InkMixture whole(inks, all);
    const std::vector<Light> colours = whole.nodes_of(means);
    std::vector<Overprint::Channels> wanted(colours.size());
    for_ranges(executor, wanted.size(), 1,
               [&](std::size_t i, std::size_t) { wanted[i] = whole.light(whole.solve(colours[i])); });
    std::vector<std::size_t> chosen = {0, all.size() - 1};
    while (chosen.size() < kMaxInkSets) {
        std::vector<unsigned> sets;
        sets.reserve(chosen.size());
        for (const std::size_t j : chosen) sets.push_back(all[j]);
        const InkMixture mixture(inks, sets);
        std::vector<std::vector<double>> gains(wanted.size(), std::vector<double>(all.size()));
        for_ranges(executor, wanted.size(), 1, [&](std::size_t i, std::size_t) {
            // How much nearer another set could bring the mixture.
            const auto seen = mixture.light(mixture.solve(colours[i]));
            const auto [red, green, blue] = colours[i];
            const double weight = 100 * static_cast<double>(lightness_slope(luminance_of(red, green, blue)));
            const Overprint::Channels off = wanted[i] - seen;
            if (weight * std::sqrt(dot(off, off)) < kNegligible) return;
            for (std::size_t j = 0; j < all.size(); ++j) {
                const Overprint::Channels way = whole.light(j) - seen;
                const double along = weight * std::max(dot(off, way), 0.0);
                if (along > 0) gains[i][j] = along * along / dot(way, way);
            }
        });
        std::vector<double> sums(all.size(), 0);
        for (const auto& each : gains) {
            for (std::size_t j = 0; j < all.size(); ++j) sums[j] += each[j];
        }
        for (const std::size_t j : chosen) sums[j] = -1;
        const auto best = std::ranges::max_element(sums);
        if (*best < kMinGain * static_cast<double>(wanted.size())) break;
        chosen.push_back(static_cast<std::size_t>(best - sums.begin()));
    }
    std::ranges::sort(chosen);
    std::vector<unsigned> sets;
    sets.reserve(chosen.size());
    for (const std::size_t j : chosen) sets.push_back(all[j]);
    return sets;
}

/// Returns the share of each cell that is lighter than each boundary between sets [sets - 1][cells].
std::vector<std::vector<float>> boundaries(const LightPlanes& light, InkMixture& mixture, Executor& executor) {
    std::vector<std::vector<float>> lighter(mixture.count() - 1, std::vector<float>(light.front().size()));
    for_pixels(executor, light.front().size(), [&](std::size_t i) {
        const InkMixture::Shares shares = mixture.shares(light_at(light, i));
        float rest = 1;
        for (std::size_t j = 0; j < lighter.size(); ++j) {
            rest -= shares[j];
            lighter[j][i] = std::clamp(rest, 0.0f, 1.0f);
        }
    });
    return lighter;
}

}  // namespace

double FieldPlan::pitch() const {
    return std::sqrt(static_cast<double>(cells.columns) * cells.rows / std::max(sites, 1.0));
}

double minority_area(const std::vector<std::vector<float>>& light, Executor& executor) {
    return sum_of_pixels(executor, light.front().size(), [&](std::size_t i) {
        float largest = 0;
        for (const std::vector<float>& channel : light)
            largest = std::max(largest, std::min(channel[i], 1 - channel[i]));
        return static_cast<double>(largest);
    });
}

FieldPlan plan_field(std::vector<std::vector<float>> light, const CellGrid& cells, const FieldOptions& options,
                     const std::stop_token& stop, Executor& executor) {
    assert(options.sites || options.radius);
    std::vector<std::vector<float>> smooth;
    for (const std::vector<float>& channel : light) {
        if (stop.stop_requested()) return {};
        smooth.push_back(smoothed(channel, cells, executor));
    }
    const Luminance luminance{0, light.size() == 1 ? std::vector{1.0f} : std::vector{0.2126f, 0.7152f, 0.0722f}};
    return FieldPlanner(cells, std::move(light), std::move(smooth), luminance, options, executor).plan();
}

FieldPlan plan_field(LightPlanes light, const InkSet& inks, const CellGrid& cells, const FieldOptions& options,
                     const std::stop_token& stop, Executor& executor) {
    assert(options.sites || options.radius);
    const std::vector<unsigned> sets = useful_sets(light, inks, cells, executor);
    InkMixture mixture(inks, sets);
    LightPlanes smooth;
    for (std::size_t c = 0; c < smooth.size(); ++c) {
        if (stop.stop_requested()) return {};
        smooth[c] = smoothed(light[c], cells, executor);
    }
    const auto luminance_at = [&](std::size_t set) {
        const auto [red, green, blue] = light_of_set(inks, sets[set]);
        return luminance_of(red, green, blue);
    };
    Luminance luminance{luminance_at(0), {}};
    for (std::size_t j = 1; j < sets.size(); ++j) luminance.steps.push_back(luminance_at(j) - luminance_at(j - 1));
    auto wanted = boundaries(light, mixture, executor);
    auto sharp = boundaries(smooth, mixture, executor);
    return FieldPlanner(cells, std::move(wanted), std::move(sharp), std::move(luminance), options, executor)
        .plan(sets, smooth);
}

}  // namespace ccdt
