// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stop_token>
#include <tuple>
#include <vector>

#include "core/base/executor.h"
#include "core/base/lanes.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/geometry/axes.h"
#include "core/points/order/point_box.h"

namespace ccdt::ordering {

/// Coefficients of a polynomial p that approximates the crowding by a neighbour. Let s be the neighbour's distance
/// divided by the reach. Then (1 - s)^5 is about (1 - s^2)^5 p(1 - s^2), with an error below 7 % for s from 1/3 to 0.9.
inline constexpr std::array<float, 5> kCrowding = {0.12919328F, -0.9645656F, 3.58161193F, -5.21164568F, 2.87339624F};

/// Limit on the reach of a pair of points, relative to the shorter of the two points' own reaches. Up to this limit,
/// the reach of a pair is the geometric mean of the two points' reaches. So where two densities meet, neither the
/// denser nor the sparser side loses more than its share.
inline constexpr double kMaxReach = 1.3;
inline constexpr float kMaxSquare = static_cast<float>(1 / (kMaxReach * kMaxReach));

using Floats = EightLanes::Floats;
using Ints = EightLanes::Ints;
inline constexpr std::uint32_t kLanes = EightLanes::kCount;
inline constexpr float kNone = -std::numeric_limits<float>::infinity();

/// Describes the pairs of points that become too near to each other while points are removed. A relative distance is
/// a distance divided by `reach` or, without it, by the reach of the pair.
struct NearPairs {
    std::optional<double> reach;  ///< at most kMaxReach times the reach of a point
    double square;                ///< limit on the squares of relative distances; pairs farther apart are not listed
    double points;                ///< number of remaining points below which a relative distance of 1 is too small
};

/// Crowding of points, computed for eight points at a time. Points are listed by cell, so neighbours are close in
/// memory.
template <class P>
class Crowding {
public:
    /// Two points that are near each other.
    struct Pair {
        float limit;  ///< number of remaining points below which the two points are too near to each other
        std::uint32_t i, j;
    };

    /// @param reaches  [n] distance within which other points crowd each point
    /// @param widest   limit on the reach of a pair of points, relative to the reach of either point
    /// @param listed   describes the pairs to list
    Crowding(const PointBox<P>& frame, const Points<P>& points, std::span<const double> reaches, double widest,
             const NearPairs& listed, Executor& executor, const std::stop_token& stop)
        : is_solid_(frame.is_solid),
          listed_(listed),
          cells_(frame.cells(points.positions)),
          numbers_(cells_.numbers()),
          positions_(points.positions),
          reaches_(reaches),
          widest_(widest),
          slots_(points.size()),
          nearness_(points.size() + kLanes),
          crowding_(points.size() + kLanes) {
        // Integer coordinates wrap around like a torus, so their difference is the way to the nearest copy.
        const double range = frame.is_torus ? 0x1p32 : 0x1p31, usual = reaches[0];
        for (auto& each : coordinates_) each.resize(points.size() + kLanes);
        has_normals_ = !points.normals.empty();
        for (auto& each : normals_) each.resize(has_normals_ ? points.size() + kLanes : 0);
        for (std::uint32_t k = 0; k < numbers_.size(); ++k) {
            const std::uint32_t i = numbers_[k];
            slots_[i] = k;
            for (std::size_t axis = 0; axis < kAxes<P>; ++axis) {
                const double of_range = along(positions_[i], axis) / along(frame.sides, axis) * range;
                coordinates_[axis][k] = static_cast<std::uint32_t>(static_cast<std::int64_t>(of_range));
            }
            for (std::size_t axis = 0; has_normals_ && axis < normals_.size(); ++axis)
                normals_[axis][k] = static_cast<float>(along(points.normals[i], axis));
            nearness_[k] = static_cast<float>(usual / reaches[i]);
        }
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis)
            units_[axis] = static_cast<float>(along(frame.sides, axis) / range / usual);
        double nearest_listed = listed_.square;  // relative to the reaches of points
        if (listed_.reach) {
            const double ratio = *listed_.reach / *std::ranges::min_element(reaches);
            nearest_listed *= std::max(1.0, ratio * ratio);
            scale_ = static_cast<float>((usual / *listed_.reach) * (usual / *listed_.reach));
        }
        std::vector<std::vector<Pair>> pairs((points.size() + kRange - 1) / kRange);
        for_ranges(executor, points.size(), kRange, [&](std::size_t begin, std::size_t end) {
            Runs runs;
            for (auto k = static_cast<std::uint32_t>(begin); k < end && !stop.stop_requested(); ++k) {
                find_near(k, 1, runs);
                const float nearest = with_lanes([&](auto) CCDT_INLINE { return add(k, runs); });
                if (nearest < nearest_listed) find_pairs(k, pairs[begin / kRange]);
            }
        });
        for (const auto& each : pairs) pairs_.insert(pairs_.end(), each.begin(), each.end());
        std::ranges::sort(pairs_, {}, [](const Pair& pair) { return std::tuple(-pair.limit, pair.i, pair.j); });
    }

    /// Returns the pairs to list, in ascending order of their relative distance. Of many coincident points, only some
    /// pairs are listed.
    std::span<const Pair> pairs() const { return pairs_; }

    float operator()(std::uint32_t point) const { return crowding_[slots_[point]]; }

    void remove(std::uint32_t point) {
        const std::uint32_t k = slots_[point];
        find_near(k, 1, runs_);
        with_lanes([&](auto) CCDT_INLINE { subtract(k); });
        crowding_[k] = kNone;
    }

private:
    using Runs = std::vector<typename BasicCellList<P>::Run>;

    static constexpr std::size_t kRange = 4'096;  ///< points per task

    void find_near(std::uint32_t k, double share, Runs& runs) const {
        const std::uint32_t i = numbers_[k];
        cells_.find_near(positions_[i], share * widest_ * reaches_[i], runs);
    }

    /// Computes, for the eight points from list position `begin` on, the squared ratio of their distance from point k
    /// to the reach of the pair. Points from `end` on, k itself, and points with an opposed normal get 1.
    /// @param scale  if not 0, factor of squares relative to the first point's reach, instead of those of the pairs
    CCDT_INLINE void get_squares(std::uint32_t k, std::uint32_t begin, std::uint32_t end, Floats& squares,
                                 float scale = 0) const {
        Floats distance{};
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) {
            EightLanes::Counts each;
            EightLanes::load(coordinates_[axis][begin], each);
            const Floats apart = __builtin_convertvector(Ints(each - coordinates_[axis][k]), Floats) * units_[axis];
            distance += apart * apart;
        }
        Floats other;
        EightLanes::load(nearness_[begin], other);
        const Floats own = Floats{} + nearness_[k];
        const Floats nearer = other > own ? other : own, capped = nearer * nearer * kMaxSquare, both = other * own;
        const Floats square = distance * (scale > 0 ? Floats{} + scale : both > capped ? both : capped);
        const Ints remaining = EightLanes::from(begin);
        Ints counts = (remaining < static_cast<std::int32_t>(end)) & (remaining != static_cast<std::int32_t>(k));
        if (kInSpace<P> && has_normals_) {
            Floats facing{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                Floats each;
                EightLanes::load(normals_[axis][begin], each);
                facing += each * normals_[axis][k];
            }
            counts &= facing >= 0;
        }
        squares = counts ? square : Floats{} + 1;
    }

    CCDT_INLINE static void get_crowding(const Floats& squares, Floats& crowding) {
        const Floats remaining = squares < 1 ? 1 - squares : Floats{}, square = remaining * remaining;
        const Floats factor =
            kCrowding[0] +
            remaining *
                (kCrowding[1] + remaining * (kCrowding[2] + remaining * (kCrowding[3] + remaining * kCrowding[4])));
        crowding = square * square * remaining * factor;
    }

    /// Computes the crowding of point k by the points in `runs`.
    /// @returns  the squared ratio of distance to reach for the nearest point
    CCDT_INLINE float add(std::uint32_t k, const Runs& runs) {
        Floats sum{}, nearest = Floats{} + 1;
        for (const auto [begin, end] : runs) {
            for (std::uint32_t each = begin; each < end; each += kLanes) {
                Floats squares, crowding;
                get_squares(k, each, end, squares);
                get_crowding(squares, crowding);
                sum += crowding;
                nearest = squares < nearest ? squares : nearest;
            }
        }
        float all = 0, least = 1;
        for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
            all += sum[lane];
            least = std::min(least, nearest[lane]);
        }
        crowding_[k] = all;
        return least;
    }

    CCDT_INLINE void subtract(std::uint32_t k) {
        for (const auto [begin, end] : runs_) {
            for (std::uint32_t each = begin; each < end; each += kLanes) {
                Floats squares, crowding;
                get_squares(k, each, end, squares);
                get_crowding(squares, crowding);
                Floats crowded;
                EightLanes::load(crowding_[each], crowded);
                crowded -= crowding;
                EightLanes::store(crowded, crowding_[each]);
            }
        }
    }

    void find_pairs(std::uint32_t k, std::vector<Pair>& pairs) const {
        const std::uint32_t i = numbers_[k];
        Runs runs;
        cells_.find_near(positions_[i], std::sqrt(listed_.square) * listed_.reach.value_or(widest_ * reaches_[i]),
                         runs);
        for (const auto [begin, end] : runs) {
            for (std::uint32_t each = begin; each < end; each += kLanes) {
                Floats squares;
                get_squares(k, each, end, squares, scale_);
                for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
                    const float square = squares[lane];
                    if (square >= listed_.square || each + lane <= k || pairs.size() >= 3 * kRange) continue;
                    const float part = is_solid_ ? square * std::sqrt(square) : square;
                    pairs.push_back({static_cast<float>(listed_.points) / part, i, numbers_[each + lane]});
                }
            }
        }
    }

    bool is_solid_;
    NearPairs listed_;
    float scale_ = 0;  ///< squared ratio of the first point's reach to listed_.reach; 0 if there is none
    BasicCellList<P> cells_;
    std::vector<std::uint32_t> numbers_;  ///< numbers of the points in list order
    std::span<const P> positions_;
    std::span<const double> reaches_;
    double widest_;
    std::vector<std::uint32_t> slots_;  ///< list position of each point
    std::vector<Pair> pairs_;
    Runs runs_;  ///< neighbours of the point being removed
    bool has_normals_;
    std::array<float, kAxes<P>> units_{};  ///< length of a unit of each coordinate, relative to the first point's reach

    // The following vectors are in list order, with eight additional entries at the end.
    std::array<std::vector<std::uint32_t>, kAxes<P>> coordinates_;
    std::array<std::vector<float>, kInSpace<P> ? 3 : 0> normals_;
    std::vector<float> nearness_;  ///< ratio of the first point's reach to each point's own reach
    std::vector<float> crowding_;
};

}  // namespace ccdt::ordering
