// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/separation.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

#include "core/halftone/inks/bounded_least_squares.h"
#include "core/halftone/inks/colour_table.h"
#include "core/picture/colour_difference.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

/// A mixture of inks: the cover of each ink, followed by the predicted light minus the wanted light in each channel.
using Node = std::array<float, kMaxInks + 3>;
using Numbers = Overprint::Numbers;
using Channels = Overprint::Channels;
static_assert(kMaxInks <= BoundedLeastSquares::kMaxNumbers);

Light mapped(const Light& light, Tone tone) {
    const auto map = [&](float value) {
        return tone == Tone::Perceptual ? lightness(to_share(value)) : to_share(value);
    };
    return {map(light.red), map(light.green), map(light.blue)};
}

/// Finds the covers of inks at which the halftone is closest to a colour. If several mixtures give the same colour,
/// finds the covers with the least sum.
///
/// Minimises by Gauss and Newton's method, with covers bounded to [0, 1]. The target moves in steps from the paper's
/// colour to the wanted colour. Each step starts from the mixture that the previous step found. So the minimisation
/// does not get stuck where black hides the effect of the other inks.
class Separator {
public:
    Separator(const InkSet& inks, Tone tone) : model_(toned(inks, tone)) {}

    Node node_of(const Light& light) const;

private:
    /// Cost of full cover by an ink, in squared colour differences. The cost decides between mixtures of the same
    /// colour, and leaves out dots that would be invisible. Without it, greys contain other inks than black. A hundred
    /// times this value causes visible errors. Shown by Separation.UsesBlackOnlyForGreys and
    /// Separation.MatchesColoursOfPicture.
    static constexpr double kPriceOfCover = 0.1;

    /// A mixture and its colour.
    struct Mixture {
        Numbers cover{};
        Lab off{};  ///< difference from the wanted colour
        double cost = 0;
    };

    Mixture mixture(const Numbers& cover, const ColourDifference& difference) const;
    Numbers linearised_minimum(const Mixture& from, const ColourDifference& difference) const;
    Numbers improve(const Numbers& cover, const Lab& wanted, int steps, double exact) const;

    Overprint model_;
};

Separator::Mixture Separator::mixture(const Numbers& cover, const ColourDifference& difference) const {
    const Lab off = difference(lab_of(model_.light(cover)));
    return {cover, off, dot(off, off) / 2 + kPriceOfCover * std::accumulate(cover.begin(), cover.end(), 0.0)};
}

/// Returns the covers that minimise the cost if colour differences are linear around the mixture `from`. Damping keeps
/// the result in the range in which the differences are nearly linear.
Numbers Separator::linearised_minimum(const Mixture& from, const ColourDifference& difference) const {
    constexpr double kStep = 1.0 / 256;
    constexpr double kDamping = 1;
    BoundedLeastSquares problem;
    problem.count = model_.count();
    std::array<Lab, kMaxInks> changes{};
    Lab wanted{-from.off[0], -from.off[1], -from.off[2]};
    for (std::size_t i = 0; i < problem.count; ++i) {
        Numbers next = from.cover;
        const double step = next[i] < 0.5 ? kStep : -kStep;
        next[i] += step;
        const Lab off = mixture(next, difference).off;
        for (std::size_t k = 0; k < wanted.size(); ++k) {
            changes[i][k] = (off[k] - from.off[k]) / step;
            wanted[k] += from.cover[i] * changes[i][k];
        }
    }
    for (std::size_t i = 0; i < problem.count; ++i) {
        problem.wanted[i] = dot(changes[i], wanted) + kDamping * from.cover[i] - kPriceOfCover;
        for (std::size_t k = 0; k < problem.count; ++k) problem.products[i][k] = dot(changes[i], changes[k]);
        problem.products[i][i] += kDamping;
    }
    return problem.minimize();
}

/// Takes steps that each lower the cost, until a step lowers it by `exact` or less.
/// @param exact  squared colour difference
Numbers Separator::improve(const Numbers& cover, const Lab& wanted, int steps, double exact) const {
    constexpr double kMinStep = 1.0 / 64;
    const ColourDifference difference(wanted);
    Mixture best = mixture(cover, difference);
    for (int step = 0; step < steps; ++step) {
        const Numbers from = best.cover, to = linearised_minimum(best, difference);
        double gain = 0;
        for (double share = 1; share >= kMinStep && !(gain > 0); share /= 2) {
            Numbers between{};
            for (std::size_t i = 0; i < between.size(); ++i) between[i] = std::lerp(from[i], to[i], share);
            const Mixture next = mixture(between, difference);
            gain = best.cost - next.cost;
            if (gain > 0) best = next;
        }
        if (!(gain > exact)) break;
    }
    return best.cover;
}

Node Separator::node_of(const Light& light) const {
    // With fewer parts, or one step in each, some colours end in a wrong mixture (Separation.MatchesColoursOfPicture).
    constexpr int kParts = 6, kStepsPerPart = 2, kMaxSteps = 20;
    constexpr double kExactPerPart = 1, kExact = 1e-4;
    const Lab paper = lab_of(model_.light({})), colour = lab_of(Overprint::channels_of(light));
    Numbers cover{};
    for (int part = 1; part <= kParts; ++part) {
        Lab wanted{};
        for (std::size_t k = 0; k < wanted.size(); ++k)
            wanted[k] = std::lerp(paper[k], colour[k], static_cast<double>(part) / kParts);
        cover = part < kParts ? improve(cover, wanted, kStepsPerPart, kExactPerPart)
                              : improve(cover, wanted, kMaxSteps, kExact);
    }
    Node node{};
    std::ranges::transform(cover, node.begin(), [](double share) { return static_cast<float>(share); });
    const Channels seen = model_.light(cover), wanted = Overprint::channels_of(light);
    for (std::size_t c = 0; c < 3; ++c) node[kMaxInks + c] = static_cast<float>(seen[c] - wanted[c]);
    return node;
}

}  // namespace

InkSet toned(const InkSet& inks, Tone tone) {
    InkSet result{inks.inks, mapped(inks.paper, tone), inks.additive};
    for (std::size_t i = 0; i < inks.inks.size(); ++i) {
        std::vector<float> cover(inks.inks.size(), 0);
        cover[i] = 1;
        const Light full = mapped(printed(inks, cover), tone);
        const auto ink = [&](float Light::*channel) {
            const float paper = result.paper.*channel;
            if (inks.additive) return full.*channel - paper;
            return paper > 0 ? full.*channel / paper : 1;
        };
        result.inks[i] = {ink(&Light::red), ink(&Light::green), ink(&Light::blue)};
    }
    return result;
}

Separation separate(const ColourPicture& picture, const InkSet& inks, Tone tone, const std::stop_token& stop,
                    Executor& executor) {
    assert(!inks.inks.empty() && inks.inks.size() <= kMaxInks);
    const std::size_t pixels = picture.red.size();
    const Channels paper = Overprint::channels_of(mapped(inks.paper, tone));
    Separation separation{std::vector(inks.inks.size(), std::vector<float>(pixels)), {}};
    separation.light.fill(std::vector<float>(pixels));
    const Separator separator(inks, tone);
    ColourTable<Node> table([&](const Light& light) { return separator.node_of(light); }, Steps::Lightness);
    const auto separate_pixel = [&](std::size_t p) {
        const float alpha = picture.alpha.empty() ? 1 : to_share(picture.alpha[p]);
        const Light light = mapped({picture.red[p], picture.green[p], picture.blue[p]}, tone);
        const Node mixture = table(light);
        for (std::size_t i = 0; i < inks.inks.size(); ++i) separation.coverage[i][p] = alpha * mixture[i];
        for (std::size_t c = 0; c < 3; ++c) {
            const float seen = static_cast<float>(Overprint::channels_of(light)[c]) + mixture[kMaxInks + c];
            separation.light[c][p] = std::lerp(static_cast<float>(paper[c]), to_share(seen), alpha);
        }
    };
    const auto columns = static_cast<std::size_t>(picture.width);
    for_rows(executor, picture.width, static_cast<std::size_t>(picture.height), [&](std::size_t row) {
        if (stop.stop_requested()) return;
        for (std::size_t p = row * columns; p < (row + 1) * columns; ++p) separate_pixel(p);
    });
    return separation;
}

std::vector<std::vector<float>> channel_coverage(const ColourPicture& picture, const InkSet& inks, Tone tone,
                                                 Executor& executor) {
    const auto map = [tone](float light) { return mapped({light, light, light}, tone).red; };
    const std::array<float, 3> paper{inks.paper.red, inks.paper.green, inks.paper.blue};
    const std::array<const Plane*, 3> planes{&picture.red, &picture.green, &picture.blue};
    std::vector<std::vector<float>> coverage(planes.size(), std::vector<float>(picture.red.size()));
    for (std::size_t c = 0; c < planes.size(); ++c) {
        const float full = inks.additive ? 1 : map(paper[c]);
        for_pixels(executor, picture.red.size(), [&](std::size_t p) {
            const float alpha = picture.alpha.empty() ? 1 : to_share(picture.alpha[p]);
            const float seen = std::lerp(map(paper[c]), map((*planes[c])[p]), alpha);
            coverage[c][p] = full > 0 ? 1 - std::min(seen / full, 1.0f) : 0;
        });
    }
    return coverage;
}

std::vector<std::size_t> share_sites(std::span<const double> ink_sums, std::size_t sites) {
    const double total = std::accumulate(ink_sums.begin(), ink_sums.end(), 0.0);
    std::vector<std::size_t> shares(ink_sums.size(), 0);
    if (!(total > 0)) return shares;
    std::vector<std::size_t> order(ink_sums.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return ink_sums[a] > ink_sums[b]; });
    std::size_t remaining = sites;
    for (const std::size_t ink : order) {
        if (remaining == 0 || !(ink_sums[ink] > 0)) break;
        shares[ink] = 1;
        --remaining;
    }
    // Each ink gets the integer part of its quota. Then each remaining site goes to the ink farthest below its quota.
    const auto quota = [&](std::size_t ink) { return ink_sums[ink] / total * static_cast<double>(sites); };
    for (const std::size_t ink : order) {
        const auto whole = static_cast<std::size_t>(quota(ink));
        const std::size_t more = std::min(remaining, whole > shares[ink] ? whole - shares[ink] : 0);
        shares[ink] += more;
        remaining -= more;
    }
    for (; remaining > 0; --remaining) {
        const auto missing = [&](std::size_t ink) { return quota(ink) - static_cast<double>(shares[ink]); };
        const std::size_t most = *std::ranges::max_element(order, {}, missing);
        ++shares[most];
    }
    return shares;
}

}  // namespace ccdt
