// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/light_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/halftone/dot_print.h"
#include "core/halftone/fitted_dots.h"
#include "core/halftone/pixel_ranges.h"

namespace ccdt {
namespace {

constexpr double kPi = std::numbers::pi;

/// Red, green and blue.
using Colour = std::array<float, 3>;

/// Solves a x = b for a symmetric, positive definite a, by Cholesky's method.
Colour solved(std::array<Colour, 3> a, Colour b) {
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k];
        a[j][j] = std::sqrt(std::max(a[j][j], 1e-12f));
        for (std::size_t i = j + 1; i < 3; ++i) {
            for (std::size_t k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
            a[i][j] /= a[j][j];
        }
        for (std::size_t k = 0; k < j; ++k) b[j] -= a[j][k] * b[k];
        b[j] /= a[j][j];
    }
    for (std::size_t j = 3; j-- > 0;) {
        for (std::size_t k = j + 1; k < 3; ++k) b[j] -= a[k][j] * b[k];
        b[j] /= a[j][j];
    }
    return b;
}

/// Fits the areas of dots to the light of the picture.
class LightFit {
public:
    LightFit(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, Executor& executor)
        : plan_(plan), executor_(executor), dots_(plan, sites, executor) {
        find_bases();
        parts_.resize(dots_.count());
        whole_up_to_.resize(dots_.count(), 0);
        gains_.resize(dots_.count());
        find_cut();
        for_pixels(executor, dots_.count(), [&](std::size_t dot) { gains_[dot] = gains_of(dot); });
    }

    const FittedDots& dots() const { return dots_; }

    void improve() {
        const auto draw = [this](std::size_t channel, std::vector<float>& image) {
            for (std::size_t dot = 0; dot < dots_.count(); ++dot) print(dot, channel, image);
            for (const ClosePair& pair : close_) print_overlap(pair, channel, image);
        };
        dots_.improve(bases_, draw, [this](std::size_t dot, std::size_t c) { return gains_[dot][c]; });
    }

    /// Divides each dot into its parts on different grounds, and finds the pairs of dots that may overlap.
    void find_cut() {
        close_.clear();
        for (const auto& [one, other] : dots_.close_pairs())
            close_.push_back({one, other, ground_at(middle_of_overlap(one, other))});
        for_pixels(executor_, dots_.count(), [&](std::size_t dot) { cut(dot); });
    }

    /// Returns the channels in which the boundary of the ground crosses a dot, as bits.
    unsigned cut_channels(std::size_t dot) const {
        unsigned bits = 0;
        for (const Part& part : parts_[dot]) bits |= part.ground ^ parts_[dot].front().ground;
        return bits;
    }

    /// Returns the channels whose ground is white at the centre of a dot, as bits.
    unsigned white_channels(std::size_t dot) const {
        return ~ground_at(dots_.site(dot)) & ((1U << plan_.channels.size()) - 1);
    }

private:
    /// Part of a dot on one ground.
    struct Part {
        unsigned ground = 0;  ///< solid inks of the ground, as bits
        float share = 1;
        Point centre;  ///< centroid relative to the dot's centre, in radii
    };

    /// Two dots that may overlap.
    struct ClosePair {
        std::uint32_t one = 0, other = 0;
        unsigned ground = 0;  ///< solid inks of the ground between the dots, as bits
    };

    unsigned ground_at(Point place) const {
        unsigned ground = 0;
        for (std::size_t c = 0; c < plan_.channels.size(); ++c)
            ground |= static_cast<unsigned>(!plan_.channels[c].ground.is_white(place)) << c;
        return ground;
    }

    /// Computes the error images without dots: light of the ground minus light of the picture.
    void find_bases() {
        const auto columns = static_cast<std::size_t>(plan_.dot_cells.columns);
        const Point scale = plan_.scale();
        for (std::size_t c = 0; c < 3; ++c) bases_[c].resize(plan_.wanted[c].size());
        for_pixels(executor_, bases_[0].size(), [&](std::size_t i) {
            bool whole = true;
            unsigned ground = 0;
            for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
                const float white = plan_.channels[c].white[i];
                whole = whole && (white == 0 || white == 1);
                ground |= static_cast<unsigned>(!(white > 0.5f)) << c;
            }
            Colour light = plan_.colours[ground];
            if (!whole) {
                light = {};
                for (int s = 0; s < 16; ++s) {
                    const Point place{(static_cast<double>(i % columns) + (s % 4 + 0.5) / 4) / scale.x,
                                      (static_cast<double>(i / columns) + (s / 4 + 0.5) / 4) / scale.y};
                    const Colour& there = plan_.colours[ground_at(place)];
                    for (std::size_t c = 0; c < 3; ++c) light[c] += there[c] / 16;
                }
            }
            for (std::size_t c = 0; c < 3; ++c) bases_[c][i] = light[c] - plan_.wanted[c][i];
        });
    }

    /// Returns the light that a dot adds to a channel, per area of the dot. Ground and flips are inks, as bits.
    float change(unsigned ground, unsigned flips, std::size_t channel) const {
        return plan_.colours[ground ^ flips][channel] - plan_.colours[ground][channel];
    }

    Colour effect(unsigned ground, unsigned flips) const {
        return {change(ground, flips, 0), change(ground, flips, 1), change(ground, flips, 2)};
    }

    Colour effect_of(std::size_t dot) const {
        Colour sum{};
        for (const Part& part : parts_[dot]) {
            const Colour own = effect(part.ground, dots_.flips(dot));
            for (std::size_t c = 0; c < 3; ++c) sum[c] += part.share * own[c];
        }
        return sum;
    }

    /// Returns the gain of a dot in each channel; see FittedDots::improve(). For each kind, let d be the light that its
    /// dots add per area, and w the share that they cover. Let M be the sum of w d d^T over all kinds. The vector of
    /// gains is w M^-1 d. So the relative change of a kind's area for an error e of the light is -d^T M^-1 e.
    Colour gains_of(std::size_t dot) const {
        constexpr float kDamping = 0.02f;  // relative to the trace; leaves errors that only few dots could correct
        const Point site = dots_.site(dot);
        const unsigned ground = ground_at(site);
        const auto unit = static_cast<float>(kPi * plan_.radius * plan_.radius);
        std::array<Colour, 3> sum{};
        const auto add = [&](const Colour& effect, float covered) {
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t j = 0; j < 3; ++j) sum[i][j] += covered * effect[i] * effect[j];
            }
        };
        for (const KindOfDots& kind : plan_.kinds) {
            const float covered = plan_.at(kind.density, site) * plan_.at(kind.area, site) / unit;
            if (covered > 0) add(effect(ground, kind.flips), covered);
        }
        const Colour own = effect_of(dot);
        const float share = dots_.planned_share(dot);
        float trace = sum[0][0] + sum[1][1] + sum[2][2];
        trace = std::max(trace, share * (own[0] * own[0] + own[1] * own[1] + own[2] * own[2]));
        if (!(trace > 0)) return {};
        for (std::size_t i = 0; i < 3; ++i) sum[i][i] += kDamping * trace;
        Colour gains = solved(sum, own);
        for (float& gain : gains) gain *= share;
        return gains;
    }

    /// Divides a dot of its current size into parts, each of which lies on one ground.
    void cut(std::size_t dot) {
        constexpr double kMargin = 1.1;  // factor on the radius that avoids a new division after small changes
        if (dots_.area(dot) <= whole_up_to_[dot]) return;
        const double reach = dots_.radius(dot);
        const Point site = dots_.site(dot);
        const unsigned middle = ground_at(site);
        const bool whole = !dots_.is_near_boundary(dot) || std::ranges::all_of(rim_samples(), [&](const Point& way) {
            return ground_at(site + kMargin * reach * way) == middle;
        });
        auto& parts = parts_[dot];
        parts.assign(1, {middle, 1, {}});
        if (whole) {
            whole_up_to_[dot] = static_cast<float>(kMargin * kMargin) * dots_.area(dot);
            return;
        }
        parts.clear();
        for (const Point& place : disc_samples()) {
            const unsigned ground = ground_at(site + reach * place);
            auto part = std::ranges::find(parts, ground, &Part::ground);
            if (part == parts.end()) part = parts.insert(part, {ground, 0, {}});
            part->share += 1;
            part->centre = part->centre + place;
        }
        for (Part& part : parts) {
            part.centre = 1.0 / static_cast<double>(part.share) * part.centre;
            part.share /= kSamplesOfDisc;
        }
    }

    /// Adds the light of a dot to the error image of a channel.
    void print(std::size_t dot, std::size_t channel, std::vector<float>& image) const {
        const float area = dots_.area(dot);
        const double reach = dots_.radius(dot);
        const Point site = dots_.site(dot);
        const auto& parts = parts_[dot];
        if (parts.size() == 1)
            return dots_.add_disc(site, reach, change(parts[0].ground, dots_.flips(dot), channel) * area, image);
        for (const Part& part : parts)
            dots_.add_light(site + reach * part.centre,
                            part.share * area * change(part.ground, dots_.flips(dot), channel), image);
    }

    /// Corrects the light where two dots overlap. print() adds the light of both dots, but an ink that both dots flip
    /// is flipped only once there.
    void print_overlap(const ClosePair& pair, std::size_t channel, std::vector<float>& image) const {
        const auto& colours = plan_.colours;
        const unsigned ground = pair.ground, a = dots_.flips(pair.one), b = dots_.flips(pair.other);
        const float change = colours[ground ^ (a | b)][channel] - colours[ground ^ a][channel] -
                             colours[ground ^ b][channel] + colours[ground][channel];
        if (change == 0) return;
        const Point way = dots_.site(pair.other) - dots_.site(pair.one);
        const double overlap =
            common_area(dots_.radius(pair.one), dots_.radius(pair.other), std::sqrt(::ccdt::dot(way, way)));
        if (!(overlap > 0)) return;
        dots_.add_light(middle_of_overlap(pair.one, pair.other), change * static_cast<float>(overlap), image);
    }

    Point middle_of_overlap(std::uint32_t one, std::uint32_t other) const {
        return ::ccdt::middle_of_overlap(dots_.site(one), dots_.radius(one), dots_.site(other), dots_.radius(other));
    }

    const TwoSidedPlan& plan_;
    Executor& executor_;
    FittedDots dots_;
    LightPlanes bases_;          ///< light of the ground minus light of the picture
    std::vector<Colour> gains_;  ///< [dots] result of gains_of()
    std::vector<ClosePair> close_;
    std::vector<std::vector<Part>> parts_;  ///< [dots] parts on different grounds
    std::vector<float> whole_up_to_;        ///< [dots] area up to which the dot lies on one ground; 0: unknown
};

}  // namespace

std::vector<SizedDots> fit_light(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop, Executor& executor) {
    LightFit sizes(plan, sites, executor);
    return fit_in_rounds(sizes, sites, fit, stop);
}

}  // namespace ccdt
