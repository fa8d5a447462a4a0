// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/ink_grounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>

#include "core/halftone/pixel_ranges.h"

namespace ccdt {

namespace {

/// Returns the inks that each possible kind flips, as bits.
std::vector<unsigned> all_kinds(std::size_t inks) {
    std::vector<unsigned> flips(kinds_of(inks));
    for (std::size_t k = 0; k < flips.size(); ++k) flips[k] = flips_of(k);
    return flips;
}

}  // namespace

InkGrounds::InkGrounds(const InkSet& inks, const LightPlanes& wanted, Executor& executor)
    : inks_(inks.inks.size()), wanted_(wanted), executor_(executor), mixture_(inks, all_kinds(inks_)) {}

void InkGrounds::reduce_cover(std::vector<std::vector<float>>& bare) {
    constexpr float kMaxCover = 0.5f, kOff = 0.15f;
    for_pixels(executor_, bare.front().size(), [&](std::size_t i) {
        const unsigned ground = ground_of(bare, i);
        if (cover(ground, i) <= kMaxCover) return;
        const unsigned turned = ground ^ best_near(bare, ground, i);
        for (std::size_t c = 0; c < inks_; ++c) {
            if ((turned >> c & 1) != 0) bare[c][i] = bare[c][i] > 0.5f ? 0.5f - kOff : 0.5f + kOff;
        }
    });
}

bool InkGrounds::replace_grounds(std::vector<std::vector<float>>& bare, const TwoSidedPlan& plan) {
    std::vector<std::uint8_t> is_bad(bare.front().size(), 0);
    for_pixels(executor_, is_bad.size(), [&](std::size_t i) {
        if (!is_unsuitable(black_channels(plan, i), i)) return;
        const unsigned best = best_near(bare, ground_of(bare, i), i);
        if (is_unsuitable(best, i)) return;
        is_bad[i] = 1;
        for (std::size_t c = 0; c < inks_; ++c) bare[c][i] = (best >> c & 1) != 0 ? 0.0f : 1.0f;
    });
    return std::ranges::find(is_bad, 1) != is_bad.end();
}

unsigned InkGrounds::ground_of(const std::vector<std::vector<float>>& bare, std::size_t cell) const {
    unsigned ground = 0;
    for (std::size_t c = 0; c < inks_; ++c) ground |= static_cast<unsigned>(!(bare[c][cell] > 0.5f)) << c;
    return ground;
}

float InkGrounds::cover(unsigned ground, std::size_t cell) {
    const KindMixture::Shares shares = mixture_.shares(ground, light_at(wanted_, cell));
    return std::accumulate(shares.begin(), shares.end(), 0.0f);
}

bool InkGrounds::is_unsuitable(unsigned ground, std::size_t cell) {
    constexpr float kOff = 0.02f;
    const Light light = light_at(wanted_, cell);
    const auto seen = mixture_.light(ground, mixture_.shares(ground, light));
    return std::max({std::abs(seen[0] - light.red), std::abs(seen[1] - light.green), std::abs(seen[2] - light.blue)}) >
           kOff;
}

unsigned InkGrounds::best_near(const std::vector<std::vector<float>>& bare, unsigned ground, std::size_t cell) {
    constexpr std::size_t kNearest = 3;
    std::array<std::size_t, kMaxInks> order{};
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto off = [&](std::size_t c) { return std::abs(bare[c][cell] - 0.5f); };
    std::ranges::stable_sort(std::span(order).first(inks_), {}, off);
    const std::size_t near = std::min(inks_, kNearest);
    float least = cover(ground, cell);
    unsigned best = ground;
    for (unsigned turned = 1; turned < 1U << near; ++turned) {
        unsigned other = ground;
        for (std::size_t n = 0; n < near; ++n) other ^= (turned >> n & 1U) << order[n];
        const float own = cover(other, cell);
        if (own < least) {
            least = own;
            best = other;
        }
    }
    return best;
}

}  // namespace ccdt
