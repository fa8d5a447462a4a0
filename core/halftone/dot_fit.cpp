// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dot_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/halftone/dot_print.h"
#include "core/halftone/fitted_dots.h"
#include "core/halftone/light_fit.h"
#include "core/halftone/overprint.h"
#include "core/halftone/pixel_ranges.h"

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;

/// A value for each channel.
using Channels = std::array<float, kMaxInks>;

/// Solves (A + e I) x = b for a symmetric, positive semidefinite A, by Cholesky's method.
Channels solved(std::array<Channels, kMaxInks> a, Channels b, std::size_t count, float e) {
    for (std::size_t j = 0; j < count; ++j) {
        a[j][j] += e;
        for (std::size_t k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k];
        a[j][j] = std::sqrt(a[j][j]);
        for (std::size_t i = j + 1; i < count; ++i) {
            for (std::size_t k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
            a[i][j] /= a[j][j];
        }
        for (std::size_t k = 0; k < j; ++k) b[j] -= a[j][k] * b[k];
        b[j] /= a[j][j];
    }
    for (std::size_t j = count; j-- > 0;) {
        for (std::size_t k = j + 1; k < count; ++k) b[j] -= a[k][j] * b[k];
        b[j] /= a[j][j];
    }
    return b;
}

/// Fits the areas of dots to the light of each channel.
class DotFit {
public:
    DotFit(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, Executor& executor)
        : plan_(plan), executor_(executor), dots_(plan, sites, executor) {
        for (const TwoSidedChannel& channel : plan.channels) {
            std::vector<float> error(channel.white);
            for_pixels(executor, error.size(), [&](std::size_t i) { error[i] -= channel.light[i]; });
            bases_.push_back(std::move(error));
        }
        cut_.resize(dots_.count() * plan.channels.size());
        whole_up_to_.resize(cut_.size(), 0);
        gains_.resize(dots_.count());
        for_pixels(executor, dots_.count(), [&](std::size_t dot) { gains_[dot] = gains_of(dot); });
        find_cut();
    }

    const FittedDots& dots() const { return dots_; }

    void improve() {
        const auto draw = [this](std::size_t channel, std::vector<float>& image) {
            for (std::size_t dot = 0; dot < dots_.count(); ++dot) print(dot, channel, image);
            for (const auto& [one, other] : close_) print_overlap(one, other, channel, image);
        };
        dots_.improve(bases_, draw, [this](std::size_t dot, std::size_t c) { return sign(dot, c) * gains_[dot][c]; });
    }

    /// Finds the dots that the boundary of a ground crosses, and the pairs that may overlap, given the current areas.
    void find_cut() {
        if (plan_.kinds.size() > 1) {
            close_ = dots_.close_pairs();
            std::erase_if(close_, [&](const auto& pair) { return (dots_.flips(pair[0]) & dots_.flips(pair[1])) == 0; });
        }
        for_pixels(executor_, dots_.count(), [&](std::size_t dot) {
            for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
                if (flips(dot, c)) cut(dot, c);
            }
        });
    }

    /// Returns the channels in which the boundary of the ground crosses a dot, as bits.
    unsigned cut_channels(std::size_t dot) const {
        unsigned bits = 0;
        for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
            const Ground& ground = plan_.channels[c].ground;
            const Cut cut = flips(dot, c) ? cut_at(dot, c) : is_whole(dot, ground) ? Cut{} : cut_of(dot, ground);
            bits |= static_cast<unsigned>(cut.brightening * cut.darkening > 0) << c;
        }
        return bits;
    }

    /// Returns the channels whose ground is white at the centre of a dot, as bits.
    unsigned white_channels(std::size_t dot) const {
        unsigned bits = 0;
        for (std::size_t c = 0; c < plan_.channels.size(); ++c)
            bits |= static_cast<unsigned>(plan_.channels[c].ground.is_white(dots_.site(dot))) << c;
        return bits;
    }

private:
    /// Returns the gain of a dot in each channel, to be multiplied by sign(); see FittedDots::improve().
    ///
    /// With these gains, the kinds around the dot together correct the error. Of all such corrections, this is the one
    /// with the least sum of squared relative changes of area, weighted by the share that each kind covers. Let A_ij be
    /// the share in which dots flip both channels i and j (see areas_at()). Let S be the diagonal matrix of signs: -1
    /// for channels with white ground, 1 for black. Let s be these signs for the channels that a kind flips, and 0 for
    /// the others. The relative change of this kind is then -s^T (S A S)^-1 e, where e holds the error of each channel.
    Channels gains_of(std::size_t dot) const {
        // Relative to the largest share; leaves errors that only few dots could correct.
        constexpr float kDamping = 0.05f;
        const std::size_t channels = plan_.channels.size();
        if (channels == 1) return {1};
        Channels share{}, sign{}, flipped{};
        for (std::size_t c = 0; c < channels; ++c) {
            const TwoSidedChannel& channel = plan_.channels[c];
            const bool white = channel.ground.is_white(dots_.site(dot));
            const float light = plan_.at(channel.light, dots_.site(dot));
            share[c] = std::max(white ? 1 - light : light, 0.0f);
            sign[c] = white ? -1.0f : 1.0f;
            flipped[c] = flips(dot, c) ? sign[c] : 0;
        }
        std::array<Channels, kMaxInks> areas = areas_at(dots_.site(dot), share);
        for (std::size_t i = 0; i < channels; ++i) {
            for (std::size_t j = 0; j < channels; ++j) areas[i][j] *= sign[i] * sign[j];
        }
        const float own = dots_.planned_share(dot);
        const float most = std::max(*std::ranges::max_element(share), own);
        Channels gains = solved(areas, flipped, channels, kDamping * most);
        for (std::size_t c = 0; c < channels; ++c) gains[c] *= own * sign[c];
        return gains;
    }

    /// Returns, for each pair of channels, the share of the area around a site in which dots flip both channels.
    /// @param share  flipped share of each channel; used only if the flipped areas are nested (TwoSidedPlan::is_nested)
    std::array<Channels, kMaxInks> areas_at(Point site, const Channels& share) const {
        std::array<Channels, kMaxInks> areas{};
        const auto for_pairs = [&](const auto& work) {
            for (std::size_t i = 0; i < plan_.channels.size(); ++i) {
                for (std::size_t j = 0; j < plan_.channels.size(); ++j) work(i, j);
            }
        };
        if (plan_.is_nested) {
            for_pairs([&](std::size_t i, std::size_t j) { areas[i][j] = std::min(share[i], share[j]); });
            return areas;
        }
        const auto unit = static_cast<float>(kPi * plan_.radius * plan_.radius);
        for (const KindOfDots& kind : plan_.kinds) {
            const float covered = plan_.at(kind.density, site) * plan_.at(kind.area, site) / unit;
            if (!(covered > 0)) continue;
            for_pairs([&](std::size_t i, std::size_t j) {
                if ((kind.flips >> i & kind.flips >> j & 1) != 0) areas[i][j] += covered;
            });
        }
        return areas;
    }

    bool flips(std::size_t dot, std::size_t channel) const { return (dots_.flips(dot) >> channel & 1) != 0; }

    /// Parts of a dot on black ground, which it brightens, and on white ground, which it darkens.
    struct Cut {
        float brightening = 0;       ///< share of the dot's area
        float darkening = 0;         ///< share of the dot's area
        Point brightened, darkened;  ///< centroids of the parts relative to the dot's centre, in radii
    };

    const Cut& cut_at(std::size_t dot, std::size_t channel) const {
        return cut_[dot * plan_.channels.size() + channel];
    }

    /// Returns the light that a dot adds to a channel, divided by the dot's area. Negative if the dot darkens.
    float sign(std::size_t dot, std::size_t channel) const {
        const Cut& cut = cut_at(dot, channel);
        return cut.brightening - cut.darkening;
    }

    /// Divides a dot by the ground of a channel. Keeps the previous result if the dot was not cut and has hardly grown.
    void cut(std::size_t dot, std::size_t channel) {
        const Ground& ground = plan_.channels[channel].ground;
        const std::size_t i = dot * plan_.channels.size() + channel;
        if (dots_.area(dot) <= whole_up_to_[i]) return;
        if (is_whole(dot, ground)) {
            cut_[i] = ground.is_white(dots_.site(dot)) ? Cut{0, 1, {}, {}} : Cut{1, 0, {}, {}};
            whole_up_to_[i] = static_cast<float>(kMargin * kMargin) * dots_.area(dot);
        } else {
            cut_[i] = cut_of(dot, ground);
        }
    }

    /// Returns whether a dot lies on a single ground, and would do so if its radius were multiplied by kMargin.
    bool is_whole(std::size_t dot, const Ground& ground) const {
        if (!dots_.is_near_boundary(dot)) return true;
        const Point site = dots_.site(dot);
        const bool white = ground.is_white(site);
        const double reach = kMargin * dots_.radius(dot);
        return std::ranges::all_of(rim_samples(),
                                   [&](const Point& way) { return ground.is_white(site + reach * way) == white; });
    }

    /// Divides a dot by samples.
    Cut cut_of(std::size_t dot, const Ground& ground) const {
        const Point site = dots_.site(dot);
        const double reach = dots_.radius(dot);
        Cut cut;
        int brightened = 0;
        for (const Point& sample : disc_samples()) {
            const bool darkens = ground.is_white(site + reach * sample);
            Point& sum = darkens ? cut.darkened : cut.brightened;
            sum = sum + sample;
            brightened += darkens ? 0 : 1;
        }
        cut.brightening = static_cast<float>(brightened) / kSamplesOfDisc;
        cut.darkening = 1 - cut.brightening;
        if (brightened > 0) cut.brightened = 1.0 / brightened * cut.brightened;
        if (brightened < kSamplesOfDisc) cut.darkened = 1.0 / (kSamplesOfDisc - brightened) * cut.darkened;
        return cut;
    }

    /// Adds the light of a dot to the error image of a channel.
    void print(std::size_t dot, std::size_t channel, std::vector<float>& image) const {
        if (!flips(dot, channel)) return;
        const Cut& cut = cut_at(dot, channel);
        const float area = dots_.area(dot);
        const double reach = dots_.radius(dot);
        const Point site = dots_.site(dot);
        if (cut.brightening == 0 || cut.darkening == 0)
            return dots_.add_disc(site, reach, (cut.brightening - cut.darkening) * area, image);
        dots_.add_light(site + reach * cut.brightened, cut.brightening * area, image);
        dots_.add_light(site + reach * cut.darkened, -cut.darkening * area, image);
    }

    /// Subtracts the light of the overlap of two dots, which print() has added twice.
    void print_overlap(std::uint32_t one, std::uint32_t other, std::size_t channel, std::vector<float>& image) const {
        if (!flips(one, channel) || !flips(other, channel)) return;
        const Point way = dots_.site(other) - dots_.site(one);
        const double distance = std::sqrt(::ccdt::dot(way, way));
        const double first = dots_.radius(one), second = dots_.radius(other);
        const double overlap = common_area(first, second, distance);
        if (!(overlap > 0)) return;
        const float sign_of_both = (sign(one, channel) + sign(other, channel)) / 2;
        dots_.add_light(middle_of_overlap(dots_.site(one), first, dots_.site(other), second),
                        -sign_of_both * static_cast<float>(overlap), image);
    }

    static constexpr double kMargin = 1.1;  ///< factor on the radius that avoids a new division after small changes

    const TwoSidedPlan& plan_;
    Executor& executor_;
    FittedDots dots_;
    std::vector<std::vector<float>> bases_;            ///< [channels] error images without dots
    std::vector<Channels> gains_;                      ///< [dots] result of gains_of()
    std::vector<std::array<std::uint32_t, 2>> close_;  ///< pairs of dots that may overlap
    std::vector<float> whole_up_to_;  ///< [dots][channels] area up to which the dot lies on one ground; 0: unknown
    std::vector<Cut> cut_;            ///< [dots][channels] default values for channels that the dot does not flip
};

}  // namespace

std::vector<SizedDots> size_dots(const TwoSidedPlan& plan, std::span<const std::vector<Point>> sites, bool fit,
                                 const std::stop_token& stop, Executor& executor) {
    if (std::ranges::all_of(sites, &std::vector<Point>::empty)) return std::vector<SizedDots>(sites.size());
    if (!plan.colours.empty()) return fit_light(plan, sites, fit, stop, executor);
    DotFit sizes(plan, sites, executor);
    return fit_in_rounds(sizes, sites, fit, stop);
}

std::vector<SizedDots> size_dots_in_pixels(const TwoSidedPlan& plan, Point size, std::vector<std::vector<Point>> sites,
                                           bool fit, const std::stop_token& stop, Executor& executor) {
    const double across = size.x / plan.cells.columns;
    const double down = size.y / plan.cells.rows;
    for (auto& kind : sites) {
        for (Point& point : kind) point = {point.x / across, point.y / down};
    }
    std::vector<SizedDots> dots = size_dots(plan, sites, fit, stop, executor);
    for (SizedDots& kind : dots) {
        for (float& radius : kind.radii) radius *= static_cast<float>(std::sqrt(across * down));
    }
    return dots;
}

}  // namespace ccdt
