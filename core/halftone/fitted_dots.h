// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/halftone/blur_pyramid.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/reduction.h"
#include "core/halftone/sized_dots.h"
#include "core/halftone/two_sided_plan.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Dots of all kinds, whose areas are fitted in rounds. The caller computes how dots change the light.
///
/// The error is measured on the dot cells of the plan. Finer detail has no effect, because the error at a dot is a mean
/// over the local spacing. Positions and areas are in cells of the plan.
class FittedDots {
public:
    /// @param sites  [kinds][sites] centres of the dots, in cells; dots are numbered in this order
    FittedDots(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, Executor& executor);

    std::size_t count() const { return sites_.size(); }
    Point site(std::size_t dot) const { return sites_[dot]; }
    unsigned flips(std::size_t dot) const { return flips_[dot]; }
    float area(std::size_t dot) const { return areas_[dot]; }
    std::span<const float> areas() const { return areas_; }
    double radius(std::size_t dot) const { return std::sqrt(static_cast<double>(areas_[dot]) / std::numbers::pi); }

    /// Returns the share of the ground around a dot that dots of its kind are planned to cover.
    float planned_share(std::size_t dot) const { return planned_[dot] / ground_per_dot_[dot]; }

    /// Returns whether the boundary of a ground may cross a dot, even if the fit gives the dot its largest area.
    bool is_near_boundary(std::size_t dot) const { return near_boundary_[dot] != 0; }

    /// Finds the pairs of dots that may overlap, given the current areas.
    std::vector<std::array<std::uint32_t, 2>> close_pairs() const;

    /// Adds light to an image of the error [dot cells]. add_light() adds it at a position; add_disc() distributes it
    /// over a disc.
    /// @param amount  light multiplied by its area, in cells of the plan
    void add_light(Point place, float amount, std::vector<float>& image) const;
    void add_disc(Point centre, double radius, float amount, std::vector<float>& image) const;

    /// Changes the area of each dot to reduce the error of the local mean of the drawing around the dot. The change is
    /// the sum over all channels of -0.85 * error * area of ground per dot * gain of the dot. One round removes errors
    /// of long wavelength. Errors whose wavelength is about one spacing take several rounds.
    ///
    /// @param bases  [channels][dot cells] error of the drawing without dots
    /// @param draw   draw(channel, image) adds the light of all dots to an image of the error
    /// @param gain   gain(dot, channel) returns the gain of a dot for errors of a channel
    template <class Draw, class Gain>
    void improve(std::span<const std::vector<float>> bases, const Draw& draw, const Gain& gain) {
        constexpr float kStep = 0.85f, kSmallest = 0.25f, kNoise = 0.004f;
        std::ranges::fill(changes_, 0.0f);
        for (std::size_t c = 0; c < bases.size(); ++c) {
            image_ = bases[c];
            draw(c, image_);
            means_.assign(image_, executor_);
            for_pixels(executor_, count(), [&](std::size_t dot) {
                const float mean = means_.at(samples_[dot]) * ground_per_dot_[dot];
                const float excess = std::max(std::abs(mean) - kNoise * planned_[dot], 0.0f);
                changes_[dot] -= kStep * gain(dot, c) * std::copysign(excess, mean);
            });
        }
        for (std::size_t dot = 0; dot < count(); ++dot)
            areas_[dot] = std::clamp(areas_[dot] + changes_[dot], kSmallest * planned_[dot], kLargest * planned_[dot]);
    }

private:
    static constexpr float kLargest = 2.5f;  // largest area that a dot can get, relative to its planned area

    void add(const KindOfDots& kind, std::span<const Point> sites);
    void find_samples();
    void find_near_boundary();

    const TwoSidedPlan& plan_;
    Executor& executor_;
    std::vector<Point> sites_;                 ///< [dots]
    std::vector<std::uint8_t> flips_;          ///< [dots] channels that the dot flips, as bits
    std::vector<float> planned_;               ///< [dots] planned area
    std::vector<float> areas_;                 ///< [dots] current area
    std::vector<float> ground_per_dot_;        ///< [dots] local area of ground per dot of the kind
    std::vector<std::uint8_t> near_boundary_;  ///< [dots] channels whose boundary is near, as bits
    Point scale_;                              ///< dot cells per cell, along each axis
    BlurPyramid means_;
    std::vector<BlurPyramid::Sample> samples_;  ///< [dots] interpolation of `means_` at each dot
    std::vector<float> image_, changes_;        ///< scratch memory of improve()
};

/// Fits the areas of dots in rounds, and returns the sizes of the dots.
///
/// @param sizes  object that fits the areas; has improve(), find_cut(), dots(), white_channels(), cut_channels()
/// @param sites  [kinds][sites]; `sizes` numbers the dots in this order
/// @param fit    whether the areas are fitted; if not, they stay as planned
/// @param stop   polled once per round; after a stop, the result has the areas of the completed rounds
template <class Fit>
std::vector<SizedDots> fit_in_rounds(Fit& sizes, std::span<const std::vector<Point>> sites, bool fit,
                                     const std::stop_token& stop) {
    constexpr int kRounds = 14, kRoundsOfCut = 4;
    for (int round = 0; fit && round < kRounds && !stop.stop_requested(); ++round) {
        if (round > 0 && round % kRoundsOfCut == 0) sizes.find_cut();
        sizes.improve();
    }
    sizes.find_cut();
    std::vector<SizedDots> dots(sites.size());
    std::size_t dot = 0;
    for (std::size_t kind = 0; kind < sites.size(); ++kind) {
        for (std::size_t i = 0; i < sites[kind].size(); ++i, ++dot) {
            dots[kind].radii.push_back(static_cast<float>(sizes.dots().radius(dot)));
            dots[kind].white.push_back(static_cast<std::uint8_t>(sizes.white_channels(dot)));
            dots[kind].cut.push_back(static_cast<std::uint8_t>(sizes.cut_channels(dot)));
        }
    }
    return dots;
}

}  // namespace ccdt
