// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/light_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/halftone/bilinear.h"
#include "core/halftone/blur_pyramid.h"
#include "core/halftone/dot_print.h"
#include "core/halftone/fit_rounds.h"
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
        : plan_(plan), executor_(executor) {
        find_base();
        for (std::size_t kind = 0; kind < sites.size(); ++kind) {
            if (!sites[kind].empty()) add(plan.kinds[kind], sites[kind]);
        }
        areas_ = planned_;
        parts_.resize(sites_.size());
        gains_.resize(sites_.size());
        find_cut();
        for_pixels(executor, sites_.size(), [&](std::size_t dot) { gains_[dot] = gains_of(dot); });
    }

    const std::vector<float>& areas() const { return areas_; }

    /// Changes the area of each dot by the error of the local mean. The method is that of size_dots() for nested kinds.
    void improve() {
        constexpr float kStep = 0.85f, kSmallest = 0.25f, kLargest = 2.5f, kNoise = 0.004f;
        const float widest = *std::ranges::max_element(ground_per_dot_);
        std::vector<float> change(sites_.size(), 0);
        for (std::size_t c = 0; c < 3; ++c) {
            std::vector<float> error(base_[c]);
            for (std::size_t dot = 0; dot < sites_.size(); ++dot) print(dot, c, error);
            for (const auto& [one, other] : close_) print_overlap(one, other, c, error);
            const BlurPyramid means(std::move(error), plan_.cells.columns, plan_.cells.rows, spread(widest), executor_);
            for_pixels(executor_, sites_.size(), [&](std::size_t dot) {
                const float ground = ground_per_dot_[dot];
                const float mean = means.at(sites_[dot], spread(ground)) * ground;
                const float excess = std::max(std::abs(mean) - kNoise * planned_[dot], 0.0f);
                change[dot] += -kStep * gains_[dot][c] * std::copysign(excess, mean);
            });
        }
        for (std::size_t dot = 0; dot < sites_.size(); ++dot)
            areas_[dot] = std::clamp(areas_[dot] + change[dot], kSmallest * planned_[dot], kLargest * planned_[dot]);
    }

    /// Divides dots by the grounds under them, and finds the pairs of dots that are close together, given the current
    /// areas.
    void find_cut() {
        close_ = close_pairs(plan_.cells, sites_, areas_);
        for_pixels(executor_, sites_.size(), [&](std::size_t dot) { cut(dot); });
    }

    /// Returns the flipped channels whose boundary crosses a dot, as bits.
    unsigned cut_channels(std::size_t dot) const {
        unsigned bits = 0;
        for (const Part& part : parts_[dot]) bits |= part.ground ^ parts_[dot].front().ground;
        return bits & flips_[dot];
    }

    /// Returns the channels whose ground is white at the centre of a dot, as bits.
    unsigned white_channels(std::size_t dot) const {
        return ~ground_at(sites_[dot]) & ((1U << plan_.channels.size()) - 1);
    }

private:
    /// Part of a dot on one ground.
    struct Part {
        unsigned ground = 0;  ///< inks, as bits
        float share = 1;
        Point centre;  ///< centroid relative to the dot's centre, in radii
    };

    /// Lower limit of the density at a dot, relative to the mean density. It limits the area of ground per dot.
    static constexpr double kMinDensity = 1e-4;

    /// Returns the standard deviation of the blur in which the error at a dot is measured: the local spacing of dots.
    static double spread(float ground) { return std::sqrt(static_cast<double>(ground)); }

    static double radius(float area) { return std::sqrt(static_cast<double>(area) / kPi); }

    float at(const std::vector<float>& values, Point site) const {
        return interpolated(values, plan_.cells.columns, plan_.cells.rows, site);
    }

    unsigned ground_at(Point place) const {
        unsigned ground = 0;
        for (std::size_t c = 0; c < plan_.channels.size(); ++c)
            ground |= static_cast<unsigned>(!plan_.channels[c].ground.is_white(place)) << c;
        return ground;
    }

    /// Computes the light of the ground minus the light of the picture.
    void find_base() {
        const auto columns = static_cast<std::size_t>(plan_.cells.columns);
        for (std::size_t c = 0; c < 3; ++c) base_[c].resize(plan_.wanted[c].size());
        for_pixels(executor_, base_[0].size(), [&](std::size_t i) {
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
                    const Point place{static_cast<double>(i % columns) + (s % 4 + 0.5) / 4,
                                      static_cast<double>(i / columns) + (s / 4 + 0.5) / 4};
                    const Colour& there = plan_.colours[ground_at(place)];
                    for (std::size_t c = 0; c < 3; ++c) light[c] += there[c] / 16;
                }
            }
            for (std::size_t c = 0; c < 3; ++c) base_[c][i] = light[c] - plan_.wanted[c][i];
        });
    }

    void add(const KindOfDots& kind, std::span<const Point> sites) {
        const double sum = sum_of_pixels(executor_, kind.density.size(),
                                         [&](std::size_t i) { return static_cast<double>(kind.density[i]); });
        const auto least = std::max(static_cast<float>(kMinDensity * sum / static_cast<double>(kind.density.size())),
                                    std::numeric_limits<float>::min());
        const auto unit = static_cast<float>(sum / static_cast<double>(sites.size()));
        for (const Point& site : sites) {
            sites_.push_back(site);
            flips_.push_back(static_cast<std::uint8_t>(kind.flips));
            planned_.push_back(at(kind.area, site));
            ground_per_dot_.push_back(unit / std::max(at(kind.density, site), least));
        }
    }

    /// Returns the light that a dot adds to a ground, divided by the dot's area.
    Colour effect(unsigned ground, unsigned flips) const {
        Colour result;
        for (std::size_t c = 0; c < 3; ++c) result[c] = plan_.colours[ground ^ flips][c] - plan_.colours[ground][c];
        return result;
    }

    Colour effect_of(std::size_t dot) const {
        Colour sum{};
        for (const Part& part : parts_[dot]) {
            const Colour own = effect(part.ground, flips_[dot]);
            for (std::size_t c = 0; c < 3; ++c) sum[c] += part.share * own[c];
        }
        return sum;
    }

    /// Returns the change of a dot's area per unit of error in each channel. Let d be the light that a kind adds and w
    /// the share that it covers. Then the relative change of a kind for an error e is -d (sum of w d d^T)^-1 e.
    Colour gains_of(std::size_t dot) const {
        constexpr float kDamping = 0.02f;  // relative to the trace; leaves errors that only few dots could correct
        const unsigned ground = ground_at(sites_[dot]);
        const auto unit = static_cast<float>(kPi * plan_.radius * plan_.radius);
        std::array<Colour, 3> sum{};
        const auto add = [&](const Colour& effect, float covered) {
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t j = 0; j < 3; ++j) sum[i][j] += covered * effect[i] * effect[j];
            }
        };
        for (const KindOfDots& kind : plan_.kinds) {
            const float covered = at(kind.density, sites_[dot]) * at(kind.area, sites_[dot]) / unit;
            if (covered > 0) add(effect(ground, kind.flips), covered);
        }
        const Colour own = effect_of(dot);
        const float share = planned_[dot] / ground_per_dot_[dot];
        float trace = sum[0][0] + sum[1][1] + sum[2][2];
        trace = std::max(trace, share * (own[0] * own[0] + own[1] * own[1] + own[2] * own[2]));
        if (!(trace > 0)) return {};
        for (std::size_t i = 0; i < 3; ++i) sum[i][i] += kDamping * trace;
        Colour gains = solved(sum, own);
        for (float& gain : gains) gain *= share;
        return gains;
    }

    /// Divides a dot with its current area into parts, each on one ground.
    void cut(std::size_t dot) {
        constexpr double kMargin = 1.1;  // on the radius, so that the result stays valid for small changes of the area
        const double reach = radius(areas_[dot]);
        const unsigned middle = ground_at(sites_[dot]);
        const bool whole = std::ranges::all_of(
            rim_samples(), [&](const Point& way) { return ground_at(sites_[dot] + kMargin * reach * way) == middle; });
        auto& parts = parts_[dot];
        parts.assign(1, {middle, 1, {}});
        if (whole) return;
        parts.clear();
        for (const Point& place : disc_samples()) {
            const unsigned ground = ground_at(sites_[dot] + reach * place);
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

    /// Adds the light of a dot to an image of the error.
    void print(std::size_t dot, std::size_t channel, std::vector<float>& image) const {
        const float area = areas_[dot];
        const double reach = radius(area);
        const auto& parts = parts_[dot];
        if (parts.size() == 1)
            return add_disc(plan_.cells, sites_[dot], reach, effect(parts[0].ground, flips_[dot])[channel] * area,
                            image);
        for (const Part& part : parts)
            add_light(plan_.cells, sites_[dot] + reach * part.centre,
                      part.share * area * effect(part.ground, flips_[dot])[channel], image);
    }

    /// Corrects the light where two dots overlap.
    void print_overlap(std::uint32_t one, std::uint32_t other, std::size_t channel, std::vector<float>& image) const {
        const Point way = sites_[other] - sites_[one];
        const double distance = std::sqrt(::ccdt::dot(way, way));
        const double first = radius(areas_[one]), second = radius(areas_[other]);
        const double overlap = common_area(first, second, distance);
        if (!(overlap > 0)) return;
        const Point place = middle_of_overlap(sites_[one], first, sites_[other], second);
        const unsigned ground = ground_at(place);
        const auto& colours = plan_.colours;
        const unsigned a = flips_[one], b = flips_[other];
        const float change = colours[ground ^ (a | b)][channel] - colours[ground ^ a][channel] -
                             colours[ground ^ b][channel] + colours[ground][channel];
        if (change != 0) add_light(plan_.cells, place, change * static_cast<float>(overlap), image);
    }

    const TwoSidedPlan& plan_;
    Executor& executor_;
    LightPlanes base_;                                 ///< light of the ground minus light of the picture
    std::vector<Point> sites_;                         ///< [dots] kind by kind
    std::vector<std::uint8_t> flips_;                  ///< [dots] channels, as bits
    std::vector<float> planned_;                       ///< [dots] area
    std::vector<float> areas_;                         ///< [dots]
    std::vector<float> ground_per_dot_;                ///< [dots] local area of ground per dot of the kind
    std::vector<Colour> gains_;                        ///< [dots] result of gains_of()
    std::vector<std::array<std::uint32_t, 2>> close_;  ///< pairs of dots that may overlap
    std::vector<std::vector<Part>> parts_;             ///< [dots]
};

}  // namespace

std::vector<SizedDots> fit_light(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop, Executor& executor) {
    LightFit sizes(plan, sites, executor);
    return fit_in_rounds(sizes, sites, fit, stop);
}

}  // namespace ccdt
