// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/nested_kinds.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/halftone/blur.h"
#include "core/halftone/kind_areas.h"
#include "core/halftone/overprint.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/visibility.h"

namespace ccdt {

namespace {

/// A value for each channel.
using Channels = std::array<float, kMaxInks>;

/// Copies the values of all channels in a cell.
/// @param values  receives the values
/// @returns       the part of `values` that is in use
std::span<const float> at_cell(std::span<const std::vector<float>> planes, std::size_t cell, Channels& values) {
    for (std::size_t c = 0; c < planes.size(); ++c) values[c] = planes[c][cell];
    return {values.data(), planes.size()};
}

/// Returns the share that dots of a kind cover if the flipped areas of the channels are nested.
/// @param shares  share that is flipped in each channel
/// @param flips   channels that the kind flips, as bits
float nested_share(std::span<const float> shares, unsigned flips) {
    float within = 1, beyond = 0;
    for (std::size_t c = 0; c < shares.size(); ++c) {
        if ((flips >> c & 1) != 0) {
            within = std::min(within, shares[c]);
        } else {
            beyond = std::max(beyond, shares[c]);
        }
    }
    return std::max(within - beyond, 0.0f);
}

/// Computes the areas and shares of kinds of dots whose flipped areas are nested.
class KindPlan {
public:
    /// @param share  [channels][cells] share of each cell that dots should flip
    KindPlan(TwoSidedPlan& plan, std::span<const std::vector<float>> share, std::span<const std::vector<float>> light,
             double radius, Executor& executor)
        : plan_(plan), share_(share), executor_(executor) {
        std::vector<float> scratch;
        const auto surroundings = [&](const std::vector<float>& values) {
            std::vector<float> means = values;
            blur(means, plan.dot_cells.columns, plan.dot_cells.rows, kSurroundingsOfDots * radius, scratch, executor);
            return means;
        };
        for (const auto& each : share) share_around_.push_back(surroundings(each));
        for (const auto& each : light) light_around_.push_back(surroundings(each));
    }

    /// Computes the share that each kind covers, and the areas of dots relative to the largest dot.
    void add_areas() {
        const std::size_t cells = share_.front().size();
        plan_.kinds.resize(kinds_of(share_.size()));
        for (std::size_t k = 0; k < plan_.kinds.size(); ++k)
            plan_.kinds[k] = {flips_of(k), std::vector<float>(cells), std::vector<float>(cells), 0};
        for_pixels(executor_, cells, [&](std::size_t i) { add_areas(i); });
        normalize_areas(plan_.kinds, executor_);
    }

private:
    void add_areas(std::size_t cell) {
        Channels own_values{}, around_values{}, light{};
        const auto own = at_cell(share_, cell, own_values), around = at_cell(share_around_, cell, around_values);
        for (float& each : light) each = 0;
        at_cell(light_around_, cell, light);
        for (float& each : light) each = std::clamp(each, 0.0f, 1.0f);
        const Visibility visibility({light.data(), own.size()});
        unsigned white = 0;
        for (std::size_t c = 0; c < own.size(); ++c)
            white |= static_cast<unsigned>(plan_.channels[c].white[cell] > 0.5f) << c;
        for (std::size_t k = 0; k < plan_.kinds.size(); ++k) {
            const float share = nested_share(own, flips_of(k));
            const float cover = std::max(nested_share(around, flips_of(k)), kMinSurroundings * share);
            plan_.kinds[k].density[cell] = share;
            plan_.kinds[k].area[cell] = relative_area(std::clamp(cover, 0.0f, 0.5f), visibility.of(flips_of(k), white));
        }
    }

    TwoSidedPlan& plan_;
    std::span<const std::vector<float>> share_;
    std::vector<std::vector<float>> share_around_, light_around_;
    Executor& executor_;
};

}  // namespace

void add_nested_kinds(TwoSidedPlan& plan, std::span<const std::vector<float>> share,
                      std::span<const std::vector<float>> light, double radius, Executor& executor) {
    KindPlan(plan, share, light, radius, executor).add_areas();
}

}  // namespace ccdt
