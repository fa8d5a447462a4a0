// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "core/base/executor.h"
#include "core/base/lanes.h"
#include "core/geometry/axes.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/points/order/crowding.h"
#include "core/points/order/point_regions.h"
#include "core/points/order/surplus.h"

namespace ccdt::ordering {

inline constexpr std::size_t kStopStride = 1'024;  ///< points between polls of the stop token

// Benchmarks ProgressivePattern and ProgressiveTone show the quality that these constants reach, and test
// ProgressiveOrder requires it. A shorter reach increases the distance of neighbours and leaves more power in low
// frequencies. A longer reach does the opposite and takes longer.
inline constexpr double kReach = 1.7;  ///< relative to the hexagonal distance
inline constexpr double kStep =
    0.7;  ///< share of the points that remain at the end of a step; reaches grow between steps

/// Least distance of remaining points, relative to the hexagonal distance. At most a third of the points of a hexagonal
/// grid can remain without any two being neighbours. The hexagonal distance is then sqrt(3) times as large, so
/// neighbours in the original grid are 1 / sqrt(3) = 0.577 apart. A larger value would separate them while more than a
/// third of the points remain, and leave more power in low frequencies.
inline constexpr double kMinDistance = 0.58;

/// Ratio of remaining points to removals that are planned ahead. Points of the best quality are nearly a hexagonal
/// grid, in which many pairs become too near to each other at about the same time. With a ratio of 16, the least
/// distance of 16,384 such points in a polygon is 0.579. With a ratio of 4, there is 1 dB more power in long waves on
/// surfaces.
inline constexpr std::size_t kPlanRatio = 8;

/// Weight of the surplus around a point, relative to the crowding of the point. A larger weight leaves less power in
/// long waves, and more power in waves of two or three spacings.
inline constexpr float kSurplusWeight = 0.5F;

/// Distance of the grid nodes on which the surplus is smoothed (see Surplus), relative to the hexagonal distance.
inline constexpr double kNodeDistance = 3;

/// Ratio of reference points (see Surplus) to remaining points above which the remaining points become the reference.
inline constexpr std::size_t kMaxReferenceRatio = 8;

/// Removes points in steps. During a step, all reaches (distances within which points crowd each other) stay the same.
template <class P>
class Elimination {
public:
    /// @param even     whether all spacings are equal
    /// @param uniform  whether the density is uniform
    Elimination(const PointBox<P>& frame, Points<P> points, std::vector<double> spacings, bool even, bool uniform,
                Regions regions, Executor& executor)
        : frame_(frame),
          points_(std::move(points)),
          spacings_(std::move(spacings)),
          widest_(even ? 1 : kMaxReach),
          uniform_(uniform),
          regions_(std::move(regions)),
          remaining_(points_.size()),
          reference_(points_.positions),
          executor_(executor) {
        std::iota(remaining_.begin(), remaining_.end(), 0U);
    }

    /// Runs a step.
    /// @returns  the removed points, in order of removal
    std::vector<std::uint32_t> step(const std::stop_token& stop) {
        target_ = static_cast<std::size_t>(static_cast<double>(remaining_.size()) * kStep);
        set_neighbours(stop);
        depth_ = regions_.depth(remaining_.size());
        begins_ = {0};
        for (const std::uint32_t count : regions_.remaining(depth_)) begins_.push_back(begins_.back() + count);
        std::vector<std::uint32_t> removed;
        removed.reserve(remaining_.size() - target_);
        while (removed.size() < remaining_.size() - target_) {
            if (removed.size() % kStopStride == 0 && stop.stop_requested()) break;
            const std::uint32_t i = next(remaining_.size() - removed.size() - 1);
            remove(i);
            removed.push_back(remaining_[i]);
        }
        keep_rest();
        return removed;
    }

    const std::vector<std::uint32_t>& remaining() const { return remaining_; }

private:
    void set_neighbours(const std::stop_token& stop) {
        const double share = std::max(static_cast<double>(target_), 1.0) / static_cast<double>(points_.size());
        const double reach = kReach * densest_spacing(share, frame_.is_solid);
        near_ = points_.selected(remaining_);
        reaches_.clear();
        for (const std::uint32_t i : remaining_) reaches_.push_back(reach * spacings_[i]);
        NearPairs listed{{}, 1, static_cast<double>(target_) * frame_.part_of(kMinDistance / kReach)};
        if (uniform_) listed.reach = reach * frame_.usual_spacing(points_.size());
        if (const std::size_t last = last_planned(target_); last > 0) {
            const double side = frame_.side_of(listed.points / static_cast<double>(last));
            listed.square = std::min(1.0, side * side);
        }
        crowd_.emplace(frame_, near_, reaches_, widest_, listed, executor_, stop);
        next_pair_ = 0;
        next_plan_ = remaining_.size();
        is_present_.assign(remaining_.size(), 1);
        if (reference_.size() > kMaxReferenceRatio * remaining_.size()) {
            sparse_ = near_.positions;
            reference_ = sparse_;
        }
        surplus_.emplace(frame_, reference_, near_.positions, node_distance());
        bounds_.resize(remaining_.size() + kLanes);
        wanted_.resize(remaining_.size() + kLanes);
        for_ranges(executor_, remaining_.size(), kStopStride, [&](std::size_t begin, std::size_t end) {
            for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
                wanted_[i] = kSurplusWeight * surplus_->wanted(i);
                bounds_[i] = without_wanted(i);
            }
        });
    }

    /// Returns the distance of the surplus' grid nodes: large enough that the nodes hardly outnumber the points.
    double node_distance() const {
        const double stay = std::max(static_cast<double>(target_), 1.0),
                     remaining = static_cast<double>(remaining_.size());
        double longest = 0;
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) longest = std::max(longest, along(frame_.sides, axis));
        return std::max({kNodeDistance * densest_spacing(stay / frame_.size, frame_.is_solid),
                         cell_side(frame_.sides, remaining), longest / remaining});
    }

    /// Returns the number of points that remain after the planned removals, if `stay` points remain now. Measured
    /// spacings are not exact enough for a plan.
    std::size_t last_planned(std::size_t stay) const {
        return uniform_ ? stay - std::min(stay, 1 + stay / kPlanRatio) : stay;
    }

    bool is_there(const typename Crowding<P>::Pair& pair) const {
        return is_present_[pair.i] != 0 && is_present_[pair.j] != 0;
    }

    /// Returns the point to remove next, after which `stay` points remain. If the nearest pair must be separated,
    /// returns one of its points. Otherwise returns the point with the largest excess in the region that is next in
    /// turn.
    std::uint32_t next(std::size_t stay) {
        const auto remaining = static_cast<float>(stay + 1);
        if (must_separate(stay)) {
            const auto [limit, i, j] = crowd_->pairs()[next_pair_];
            return excess(i, remaining) > excess(j, remaining) ? i : j;
        }
        const std::size_t region = regions_.next_region(depth_);
        return most_crowded(begins_[region], begins_[region + 1], remaining);
    }

    /// Whether the next removal, after which `stay` points remain, must separate the nearest pair. It must if the pair
    /// would be too near, or if too many pairs become too near soon. Each removal is expected to separate one pair.
    bool must_separate(std::size_t stay) {
        const auto pairs = crowd_->pairs();
        while (next_pair_ < pairs.size() && !is_there(pairs[next_pair_])) ++next_pair_;
        if (next_pair_ == pairs.size()) return false;
        if (pairs[next_pair_].limit > static_cast<float>(stay)) return true;
        if (stay < next_plan_) plan(stay);
        return is_urgent_;
    }

    /// Determines `is_urgent_`, and for how many removals it is valid. If `count` pairs become too near before `limit`
    /// points remain, their separation must begin when limit + count points remain.
    void plan(std::size_t stay) {
        // If there are very many points, planning anew after few removals would take too long.
        const std::size_t longest = 1 + stay / 64, shortest = 1 + stay / 4'096, urgent = 1 + stay / 1'024;
        const auto last = static_cast<float>(last_planned(stay)), latest = static_cast<float>(stay + 2 - shortest);
        float count = 0, begin = 0;
        for (const auto& pair : crowd_->pairs().subspan(next_pair_)) {
            if (pair.limit <= last || begin > latest) break;
            if (is_there(pair)) begin = std::max(begin, pair.limit + ++count);
        }
        is_urgent_ = begin > latest;
        const auto spare = static_cast<std::size_t>(std::max(latest - begin, 0.0F));
        const std::size_t removals = is_urgent_ ? urgent : std::min(longest, spare + shortest);
        next_plan_ = stay - std::min(stay, removals - 1);
    }

    float without_wanted(std::uint32_t i) const { return (*crowd_)(i) + kSurplusWeight * surplus_->actual(i); }
    float excess(std::uint32_t i, float remaining) const { return without_wanted(i) - remaining * wanted_[i]; }

    /// Returns the point in [begin, end) with the largest excess. The excess of a point is the crowding by near points
    /// plus the weighted surplus. `bounds_` stores earlier values of the excess without the wanted part of the surplus.
    /// A step only removes points, so these values never increase, and outdated ones are still upper bounds.
    /// @param remaining  number of points that remain in the domain
    std::uint32_t most_crowded(std::uint32_t begin, std::uint32_t end, float remaining) {
        Ints found;
        with_lanes([&](auto) CCDT_INLINE { find_largest(begin, end, remaining, found); });
        std::uint32_t most = begin;
        float largest = kNone;
        const auto look_at = [&](std::uint32_t i) {
            bounds_[i] = without_wanted(i);
            const float own = bounds_[i] - remaining * wanted_[i];
            if (own < largest || (own == largest && i > most)) return;
            largest = own;
            most = i;
        };
        for (std::uint32_t lane = 0; lane < kLanes; ++lane) look_at(static_cast<std::uint32_t>(found[lane]));
        for (std::uint32_t i = begin; i < end; ++i) {
            if (bounds_[i] - remaining * wanted_[i] > largest) look_at(i);
        }
        return most;
    }

    /// Finds, for each lane, the point with the largest upper bound of its excess. A lane has every eighth point.
    CCDT_INLINE void find_largest(std::uint32_t begin, std::uint32_t end, float remaining, Ints& found) const {
        Floats most = Floats{} + kNone;
        found = Ints{} + static_cast<std::int32_t>(begin);
        for (std::uint32_t i = begin; i < end; i += kLanes) {
            const Ints each = EightLanes::from(i);
            Floats bounds, wanted;
            EightLanes::load(bounds_[i], bounds);
            EightLanes::load(wanted_[i], wanted);
            const Floats bound = bounds - remaining * wanted;
            const Ints more = (bound > most) & (each < static_cast<std::int32_t>(end));
            most = more ? bound : most;
            found = more ? each : found;
        }
    }

    void remove(std::uint32_t i) {
        is_present_[i] = 0;
        bounds_[i] = kNone;
        crowd_->remove(i);
        surplus_->remove(i);
        const auto region = std::ranges::upper_bound(begins_, i) - begins_.begin() - 1;
        regions_.count_removal(depth_, static_cast<std::size_t>(region));
    }

    void keep_rest() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < remaining_.size(); ++i) {
            if (is_present_[i] != 0) remaining_[kept++] = remaining_[i];
        }
        remaining_.resize(kept);
    }

    PointBox<P> frame_;
    Points<P> points_;              ///< [n] in the frame
    std::vector<double> spacings_;  ///< [n] local spacings
    double widest_;                 ///< limit on the reach of a pair relative to a point's own reach
    bool uniform_;
    Regions regions_;
    std::vector<std::uint32_t> remaining_;
    std::span<const P> reference_;  ///< positions of points that represent the wanted density
    std::vector<P> sparse_;         ///< storage for reference_, except while reference_ refers to points_
    Executor& executor_;

    // State of the current step. It covers the points that remained at the beginning of the step.
    std::size_t target_ = 0;             ///< number of points that remain at the end of the step
    int depth_ = 0;                      ///< depth of the regions
    std::vector<std::uint32_t> begins_;  ///< start of each region
    Points<P> near_;
    std::vector<double> reaches_;
    std::optional<Crowding<P>> crowd_;
    std::vector<std::uint8_t> is_present_;
    std::optional<Surplus<P>> surplus_;
    std::vector<float> wanted_;  ///< wanted part of the weighted surplus, divided by the number of remaining points
    std::vector<float> bounds_;  ///< upper bounds of the excess without its wanted part
    std::size_t next_pair_ = 0;  ///< the nearest pair that remains
    std::size_t next_plan_ = 0;  ///< number of remaining points below which the next plan is made
    bool is_urgent_ = false;     ///< whether pairs must be separated before they are too near
};

}  // namespace ccdt::ordering
