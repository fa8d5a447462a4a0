// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/mixed_kinds.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "core/halftone/blur.h"
#include "core/halftone/kind_areas.h"
#include "core/halftone/kind_mixture.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/sharpening.h"
#include "core/halftone/visibility.h"

namespace ccdt {

namespace {

/// A value for each channel.
using Channels = std::array<float, kMaxInks>;

/// Computes the shares and areas of kinds such that the mean colour of ground and dots is the colour of the picture.
class MixturePlan {
public:
    /// @param sigma  standard deviation, in cells, of the blur that sharpening compensates
    MixturePlan(TwoSidedPlan& plan, const InkSet& inks, const LightPlanes& light, double sigma, Executor& executor)
        : plan_(plan), executor_(executor) {
        for (std::size_t c = 0; c < light.size(); ++c)
            sharp_[c] = sharpened(light[c], plan.dot_cells.columns, plan.dot_cells.rows, sigma, executor);
        grounds_.resize(cells());
        for_pixels(executor, cells(),
                   [&](std::size_t i) { grounds_[i] = static_cast<std::uint8_t>(black_channels(plan, i)); });
        choose_kinds(inks);
    }

    /// Finds the light that dots on the ground of a cell cannot reproduce, and adds it to the surroundings of the cell.
    /// @param wanted  light of the picture; modified
    /// @param radius  radius of the dots, in cells
    void distribute_missing_light(LightPlanes& wanted, double radius) {
        constexpr int kRounds = 2;
        std::vector<float> scratch;
        const LightPlanes picture = wanted;
        for (int round = 0; round < kRounds; ++round) {
            LightPlanes missing = picture;
            for_pixels(executor_, cells(), [&](std::size_t i) {
                const unsigned ground = grounds_[i];
                const auto seen = mixture_->light(ground, mixture_->shares(ground, light_at(wanted, i)));
                for (std::size_t c = 0; c < 3; ++c) missing[c][i] -= seen[c];
            });
            for (std::size_t c = 0; c < 3; ++c) {
                blur(missing[c], plan_.dot_cells.columns, plan_.dot_cells.rows, kSurroundingsOfDots * radius, scratch,
                     executor_);
                for_pixels(executor_, cells(), [&](std::size_t i) {
                    wanted[c][i] += missing[c][i];
                    sharp_[c][i] += missing[c][i];
                });
            }
        }
    }

    /// Sets the light of each channel to the share of each cell that the ink leaves bare.
    /// @param wanted  wanted light; determines the shares of the kinds
    void set_light(const LightPlanes& wanted) {
        for (TwoSidedChannel& channel : plan_.channels) channel.light.resize(cells());
        for_pixels(executor_, cells(), [&](std::size_t i) {
            Channels bare{};
            add_bare(0, 0, 1, i, light_at(wanted, i), bare);
            for (std::size_t c = 0; c < plan_.channels.size(); ++c) plan_.channels[c].light[i] = bare[c];
        });
    }

    /// Sets the share that each kind covers. A cell that a boundary crosses gets the mean shares of nearby cells
    /// without a boundary.
    void add_shares() {
        for_pixels(executor_, cells(), [&](std::size_t i) {
            if (!is_whole(i)) return;
            const KindMixture::Shares shares = mixture_->shares(grounds_[i], light_at(sharp_, i));
            for (std::size_t k = 0; k < plan_.kinds.size(); ++k) plan_.kinds[k].density[i] = shares[k];
        });
        for_pixels(executor_, cells(), [&](std::size_t i) {
            if (!is_whole(i)) average_shares_around(i);
        });
    }

    /// Sets the relative areas of dots. Dots that are hardly visible on one ground could be large, but would be blots
    /// on the ground beside it. So the area follows from the nearby ground on which the kind is most visible.
    /// @param radius  radius of the dots, in cells
    void add_areas(double radius) {
        constexpr float kMinVisibility = 0.02f;  // lower limit; for example, an ink under black is invisible
        constexpr double kReach = 2, kMaxReach = 8;
        const auto reach = plan_.colours.empty()
                               ? std::size_t{0}
                               : static_cast<std::size_t>(std::ceil(std::min(kReach * radius, kMaxReach)));
        const std::vector<std::uint64_t> grounds_of_cells = grounds_around(reach);
        std::vector<float> scratch;
        LightPlanes around = sharp_;
        for (std::vector<float>& each : around)
            blur(each, plan_.dot_cells.columns, plan_.dot_cells.rows, kSurroundingsOfDots * radius, scratch, executor_);
        for (KindOfDots& kind : plan_.kinds) {
            kind.area = kind.density;
            blur(kind.area, plan_.dot_cells.columns, plan_.dot_cells.rows, kSurroundingsOfDots * radius, scratch,
                 executor_);
        }
        for_pixels(executor_, cells(), [&](std::size_t i) {
            const auto [red, green, blue] = light_at(around, i);
            const Visibility visibility(std::array{red, green, blue});
            for (std::size_t k = 0; k < plan_.kinds.size(); ++k) {
                KindOfDots& kind = plan_.kinds[k];
                const float cover = std::max(kind.area[i], kMinSurroundings * kind.density[i]);
                float seen = kMinVisibility;
                for (std::uint64_t left = grounds_of_cells[i]; left != 0; left &= left - 1) {
                    const auto ground = static_cast<unsigned>(std::countr_zero(left));
                    seen = std::max(seen, visibility.of(mixture_->change(ground, k)));
                }
                kind.area[i] = relative_area(std::clamp(cover, 0.0f, 0.5f), seen);
            }
        });
        normalize_areas(plan_.kinds, executor_);
    }

private:
    std::size_t cells() const { return sharp_[0].size(); }

    /// Returns whether no boundary crosses a cell.
    bool is_whole(std::size_t cell) const {
        return std::ranges::all_of(plan_.channels, [cell](const TwoSidedChannel& channel) {
            return channel.white[cell] == 0 || channel.white[cell] == 1;
        });
    }

    /// Chooses the kinds that cover the largest area, estimated from a sample of cells.
    void choose_kinds(const InkSet& inks) {
        constexpr std::size_t kSamples = 8192;
        const std::size_t all = kinds_of(inks.inks.size());
        std::vector<unsigned> flips(all);
        for (std::size_t k = 0; k < all; ++k) flips[k] = flips_of(k);
        KindMixture any(inks, flips);
        if (all > kMaxInkKinds) {
            std::vector<double> sums(all, 0);
            const std::size_t step = std::max(cells() / kSamples, std::size_t{1});
            for (std::size_t i = 0; i < cells(); i += step) {
                const KindMixture::Shares shares = any.shares(grounds_[i], light_at(sharp_, i));
                for (std::size_t k = 0; k < all; ++k) sums[k] += static_cast<double>(shares[k]);
            }
            std::ranges::stable_sort(flips, std::ranges::greater(), [&](unsigned kind) { return sums[kind - 1]; });
            flips.resize(kMaxInkKinds);
            std::ranges::sort(flips);
        }
        for (const unsigned kind : flips) plan_.kinds.push_back({kind, std::vector<float>(cells()), {}, 0});
        mixture_.emplace(inks, std::move(flips));
    }

    /// Adds to `bare` the share of a cell that each ink leaves bare, summed over all grounds in the cell. Divides the
    /// cell by the grounds of one channel after the other, by recursion.
    /// @param channel  next channel by whose ground the cell is divided
    /// @param ground   solid inks among the previous channels, as bits
    /// @param weight   share of the cell that has this ground in the previous channels
    void add_bare(std::size_t channel, unsigned ground, float weight, std::size_t cell, const Light& wanted,
                  Channels& bare) {
        if (channel < plan_.channels.size()) {
            const float white = plan_.channels[channel].white[cell];
            if (white > 0) add_bare(channel + 1, ground, weight * white, cell, wanted, bare);
            if (white < 1) add_bare(channel + 1, ground | 1U << channel, weight * (1 - white), cell, wanted, bare);
            return;
        }
        const KindMixture::Shares shares = mixture_->shares(ground, wanted);
        for (std::size_t c = 0; c < plan_.channels.size(); ++c) {
            float flipped = 0;
            for (std::size_t k = 0; k < plan_.kinds.size(); ++k) {
                if ((plan_.kinds[k].flips >> c & 1) != 0) flipped += shares[k];
            }
            bare[c] += weight * ((ground >> c & 1) != 0 ? flipped : 1 - flipped);
        }
    }

    /// Returns for each cell the grounds within `reach` cells along both axes; bit g stands for the ground of inks g.
    std::vector<std::uint64_t> grounds_around(std::size_t reach) const {
        static_assert(kMaxInks <= 6);
        const auto columns = static_cast<std::size_t>(plan_.dot_cells.columns);
        const auto rows = static_cast<std::size_t>(plan_.dot_cells.rows);
        std::vector<std::uint64_t> across(cells(), 0), around(cells(), 0);
        for_pixels(executor_, cells(), [&](std::size_t i) {
            const std::size_t column = i % columns;
            const std::size_t last = i + std::min(columns - 1 - column, reach);
            for (std::size_t j = i - std::min(column, reach); j <= last; ++j)
                across[i] |= std::uint64_t{1} << grounds_[j];
        });
        for_pixels(executor_, cells(), [&](std::size_t i) {
            const std::size_t row = i / columns;
            const std::size_t last = i + std::min(rows - 1 - row, reach) * columns;
            for (std::size_t j = i - std::min(row, reach) * columns; j <= last; j += columns) around[i] |= across[j];
        });
        return around;
    }

    /// Sets the shares of a cell to the mean shares of the nearby cells that no boundary crosses. If there are no such
    /// cells, the shares follow from the cell's own colour.
    void average_shares_around(std::size_t cell) {
        constexpr std::size_t kReach = 2;
        const auto columns = static_cast<std::size_t>(plan_.dot_cells.columns);
        const auto rows = static_cast<std::size_t>(plan_.dot_cells.rows);
        const std::size_t column = cell % columns, row = cell / columns;
        KindMixture::Shares sum{};
        float count = 0;
        for (std::size_t y = row - std::min(row, kReach); y <= std::min(row + kReach, rows - 1); ++y) {
            for (std::size_t x = column - std::min(column, kReach); x <= std::min(column + kReach, columns - 1); ++x) {
                if (!is_whole(y * columns + x)) continue;
                for (std::size_t k = 0; k < plan_.kinds.size(); ++k) sum[k] += plan_.kinds[k].density[y * columns + x];
                ++count;
            }
        }
        if (count == 0) sum = mixture_->shares(grounds_[cell], light_at(sharp_, cell));
        for (std::size_t k = 0; k < plan_.kinds.size(); ++k)
            plan_.kinds[k].density[cell] = sum[k] / std::max(count, 1.0f);
    }

    TwoSidedPlan& plan_;
    Executor& executor_;
    LightPlanes sharp_;                  ///< sharpened light of the picture
    std::vector<std::uint8_t> grounds_;  ///< [cells] inks of the ground, as bits
    std::optional<KindMixture> mixture_;
};

}  // namespace

void add_mixed_kinds(TwoSidedPlan& plan, const InkSet& inks, LightPlanes light, double radius, double sigma,
                     const std::stop_token& stop, Executor& executor) {
    MixturePlan mixture(plan, inks, light, sigma, executor);
    mixture.distribute_missing_light(light, radius);
    mixture.set_light(light);
    if (stop.stop_requested()) return;
    mixture.add_shares();
    mixture.add_areas(radius);
}

}  // namespace ccdt
