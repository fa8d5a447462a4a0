// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/ink_mixture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/elementary.h"
#include "core/picture/colour_difference.h"
#include "core/picture/srgb.h"

namespace ccdt {

namespace {

using Channels = Overprint::Channels;
using Matrix = std::array<Lab, 3>;

/// Solves a x = b for a symmetric positive definite matrix, by Cramer's rule.
Lab solved(const Matrix& a, const Lab& b) {
    const auto determinant = [](const Lab& p, const Lab& q, const Lab& r) {
        return p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) +
               p[2] * (q[0] * r[1] - q[1] * r[0]);
    };
    const double all = determinant(a[0], a[1], a[2]);
    return {determinant(b, a[1], a[2]) / all, determinant(a[0], b, a[2]) / all, determinant(a[0], a[1], b) / all};
}

/// Minimizes (sum of w (D + tau log w)) + kExact |off + (sum of w v)|^2 over shares w with the sum 1.
///
/// The dual problem has three variables, and its maximum is found by Newton's method. The factor grows from kFirst to
/// kExact in steps. For a colour outside the gamut, the dual variables are large. Newton's method would not reach them
/// from 0 within kMaxSteps, because one share is nearly 1 in most of these steps.
class EntropyFit {
public:
    static constexpr double kTau = 150, kFirst = 10, kExact = 1e6;

    /// @param costs      [sets] D
    /// @param positions  [sets] v
    EntropyFit(std::span<const double> costs, std::span<const Lab> positions, const Lab& off)
        : costs_(costs), positions_(positions), off_(off), shares_(costs.size()) {}

    std::vector<double> minimize() {
        constexpr double kFactor = 10;
        Lab dual{};
        for (; exact_ <= kExact; exact_ *= kFactor) maximize(dual);
        evaluate(dual);
        return shares_;
    }

private:
    /// Maximizes the dual objective by Newton's method.
    void maximize(Lab& dual) {
        constexpr int kMaxSteps = 60, kMaxHalvings = 40;
        constexpr double kNear = 1e-9;
        double value = evaluate(dual);
        for (int step = 0; step < kMaxSteps; ++step) {
            const Lab mean = mean_position();
            Lab slope{};
            Matrix curvature{};
            for (std::size_t r = 0; r < 3; ++r) {
                slope[r] = off_[r] + mean[r] - dual[r] / (2 * exact_);
                curvature[r][r] = 1 / (2 * exact_);
            }
            for (std::size_t j = 0; j < shares_.size(); ++j) {
                for (std::size_t r = 0; r < 3; ++r) {
                    for (std::size_t s = 0; s < 3; ++s)
                        curvature[r][s] +=
                            shares_[j] / kTau * (positions_[j][r] - mean[r]) * (positions_[j][s] - mean[s]);
                }
            }
            const Lab way = solved(curvature, slope);
            if (!(dot(way, slope) > kNear)) break;
            double part = 1;
            Lab next{};
            double there = 0;
            for (int halving = 0; halving < kMaxHalvings; ++halving, part /= 2) {
                for (std::size_t r = 0; r < 3; ++r) next[r] = dual[r] + part * way[r];
                there = evaluate(next);
                if (there > value + 0.1 * part * dot(way, slope)) break;
            }
            if (!(there > value)) break;
            dual = next;
            value = there;
        }
    }

    /// Computes the shares for given dual variables, and returns the dual objective.
    double evaluate(const Lab& dual) {
        double least = std::numeric_limits<double>::infinity(), sum = 0;
        for (std::size_t j = 0; j < shares_.size(); ++j) {
            shares_[j] = costs_[j] + dot(dual, positions_[j]);
            least = std::min(least, shares_[j]);
        }
        for (double& each : shares_) {
            each = elementary::exp((least - each) / kTau);
            sum += each;
        }
        for (double& each : shares_) each /= sum;
        return least - kTau * elementary::log(sum) + dot(dual, off_) - dot(dual, dual) / (4 * exact_);
    }

    Lab mean_position() const {
        Lab mean{};
        for (std::size_t j = 0; j < shares_.size(); ++j) {
            for (std::size_t r = 0; r < 3; ++r) mean[r] += shares_[j] * positions_[j][r];
        }
        return mean;
    }

    std::span<const double> costs_;
    std::span<const Lab> positions_;
    Lab off_;
    double exact_ = kFirst;
    std::vector<double> shares_;
};

}  // namespace

Light light_of_set(const InkSet& inks, unsigned set) {
    std::array<float, kMaxInks> cover{};
    for (std::size_t ink = 0; ink < inks.inks.size(); ++ink) cover[ink] = static_cast<float>(set >> ink & 1);
    return printed(inks, std::span(cover).first(inks.inks.size()));
}

std::vector<unsigned> sets_by_luminance(const InkSet& inks) {
    std::vector<unsigned> sets(std::size_t{1} << inks.inks.size());
    std::iota(sets.begin(), sets.end(), 0U);
    std::ranges::stable_sort(sets, {}, [](unsigned set) { return std::popcount(set); });
    const auto is_near = [&](unsigned a, unsigned b) {
        constexpr float kNear = 0.002f;
        const Light one = light_of_set(inks, a), other = light_of_set(inks, b);
        return std::max({std::abs(one.red - other.red), std::abs(one.green - other.green),
                         std::abs(one.blue - other.blue)}) < kNear;
    };
    std::vector<unsigned> different;
    for (const unsigned set : sets) {
        if (std::ranges::none_of(different, [&](unsigned other) { return is_near(set, other); }))
            different.push_back(set);
    }
    sets = std::move(different);
    std::ranges::stable_sort(sets, {}, [&](unsigned set) {
        const auto [red, green, blue] = light_of_set(inks, set);
        return luminance_of(red, green, blue);
    });
    return sets;
}

InkMixture::InkMixture(const InkSet& inks, std::vector<unsigned> sets)
    : sets_(std::move(sets)), table_([this](const Light& light) { return solve(light); }, Steps::Light, sets_.size()) {
    for (const unsigned set : sets_) colours_.push_back(Overprint::channels_of(light_of_set(inks, set)));
}

InkMixture::Shares InkMixture::solve(const Light& wanted) const {
    constexpr int kMaxRounds = 6;
    constexpr double kStep = 1e-3, kNear = 0.005;
    const ColourDifference difference(lab_of(Overprint::channels_of(wanted)));
    std::vector<double> costs, shares;
    for (const Channels& colour : colours_) {
        const Lab off = difference(lab_of(colour));
        costs.push_back(dot(off, off));
    }
    Channels light = Overprint::channels_of(wanted);
    Shares result{};
    for (int round = 0; round < kMaxRounds; ++round) {
        // The difference of the mean is linear in the shares near the current light.
        Lab off = difference(lab_of(light));
        std::array<Lab, 3> slopes{};
        for (std::size_t c = 0; c < 3; ++c) {
            Channels next = light;
            const double way = next[c] < 0.5 ? kStep : -kStep;
            next[c] += way;
            const Lab there = difference(lab_of(next));
            for (std::size_t r = 0; r < 3; ++r) slopes[c][r] = (there[r] - off[r]) / way;
        }
        std::vector<Lab> positions(colours_.size(), Lab{});
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) {
                off[r] -= slopes[c][r] * light[c];
                for (std::size_t j = 0; j < positions.size(); ++j) positions[j][r] += slopes[c][r] * colours_[j][c];
            }
        }
        shares = EntropyFit(costs, positions, off).minimize();
        std::ranges::transform(shares, result.begin(), [](double each) { return static_cast<float>(each); });
        const Channels seen = this->light(result);
        const Lab before = difference(lab_of(light)), after = difference(lab_of(seen));
        light = seen;
        if (std::abs(std::sqrt(dot(before, before)) - std::sqrt(dot(after, after))) < kNear && round > 0) break;
        if (dot(after, after) < kNear * kNear) break;
    }
    return result;
}

Channels InkMixture::light(const Shares& shares) const {
    Channels sum{};
    for (std::size_t j = 0; j < colours_.size(); ++j) {
        for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(shares[j]) * colours_[j][c];
    }
    return sum;
}

}  // namespace ccdt
