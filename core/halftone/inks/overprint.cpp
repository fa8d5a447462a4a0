// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/overprint.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <numeric>

#include "core/base/elementary.h"

namespace ccdt {

namespace {

using Channels = Overprint::Channels;

/// Returns the overlap of two inks, divided by the overlap that independent patterns would have.
///
/// @param a, b    total dot area of each of the two inks per unit area
/// @param others  total dot area of all other inks per unit area
/// Fitted to 1,300 flat tints of two to four inks, with 8,000 dots and quality standard. The root mean square error of
/// the share that both inks cover is 0.002. Shown by Overprint.MatchesRasterizedDots.
double overlap(double a, double b, double others) {
    const double crowding =
        1.94 * (a * a + b * b) + 0.73 * a * b + 0.91 * (1 - elementary::exp(-others / 0.68)) - 0.106;
    return 1 - elementary::exp(-std::max(0.0, crowding));
}

/// Returns the coverage that an ink loses because dots of other inks push its dots. These pushes make the pattern of
/// the ink less even.
///
/// @param own     total dot area of the ink per unit area
/// @param others  total dot area of all other inks per unit area
/// Fitted in the same way as overlap(); the error is 0.002.
double disorder(double own, double others) {
    const double crowd = others / 0.22, off = (own - 1.015) / 0.243;
    return 0.016 * (1 - elementary::exp(-crowd * crowd)) * elementary::exp(-off * off / 2);
}

}  // namespace

Light printed(const InkSet& inks, std::span<const float> cover) {
    Light light = inks.paper;
    for (std::size_t i = 0; i < inks.inks.size(); ++i) {
        const auto lay = [&](float below, float ink) {
            return inks.additive ? std::min(1.0f, below + cover[i] * ink) : below * (1 - cover[i] * (1 - ink));
        };
        light = {lay(light.red, inks.inks[i].red), lay(light.green, inks.inks[i].green),
                 lay(light.blue, inks.inks[i].blue)};
    }
    return light;
}

Overprint::Overprint(const InkSet& inks) : count_(inks.inks.size()) {
    assert(count_ >= 1 && count_ <= kMaxInks);
    for (std::size_t combination = 0; combination < std::size_t{1} << count_; ++combination) {
        const int inks_in_it = std::popcount(combination);
        for (std::size_t c = 0; c < 3; ++c) {
            double change = channels_of(inks.paper)[c];
            for (std::size_t i = 0; i < count_; ++i) {
                if ((combination >> i & 1) == 0) continue;
                const double ink = channels_of(inks.inks[i])[c];
                change = !inks.additive ? change * (ink - 1) : inks_in_it == 1 ? ink : 0;
            }
            changes_[combination][c] = change;
        }
    }
}

Overprint::Shares Overprint::shares(const Numbers& cover) const {
    Numbers dots{}, covered{};
    for (std::size_t i = 0; i < count_; ++i) dots[i] = curve_.dots(cover[i]);
    const double all = std::accumulate(dots.begin(), dots.end(), 0.0);
    for (std::size_t i = 0; i < count_; ++i)
        covered[i] = cover[i] > 0 ? cover[i] - disorder(dots[i], all - dots[i]) : 0;
    std::array<Numbers, kMaxInks> overlaps{};
    for (std::size_t i = 0; i < count_; ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            const double product = covered[i] * covered[k], least = covered[i] + covered[k] - 1;
            if (!(product > 0)) continue;
            overlaps[i][k] = std::max(overlap(dots[i], dots[k], all - dots[i] - dots[k]), least / product);
        }
    }
    Shares shares{1};
    for (std::size_t i = 0; i < count_; ++i) {
        const std::size_t bit = std::size_t{1} << i;
        for (std::size_t below = 0; below < bit; ++below) {
            double share = shares[below] * covered[i];
            for (std::size_t k = 0; k < i; ++k) {
                if ((below >> k & 1) != 0) share *= overlaps[i][k];
            }
            shares[bit | below] = share;
        }
    }
    return shares;
}

Channels Overprint::light(const Numbers& cover) const {
    const Shares shares = this->shares(cover);
    Channels light{};
    for (std::size_t inks = 0; inks < std::size_t{1} << count_; ++inks) {
        for (std::size_t c = 0; c < 3; ++c) light[c] += shares[inks] * changes_[inks][c];
    }
    return light;
}

}  // namespace ccdt
