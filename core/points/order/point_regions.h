// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/axes.h"

namespace ccdt::ordering {

/// Least number of remaining points in a region. Fewer points mean less choice and more noise. More points take
/// longer.
inline constexpr std::size_t kMinRegionPoints = 256;

/// Returns the axis along which some points extend farthest.
template <class P>
std::size_t longest_axis(std::span<const P> positions, std::span<const std::uint32_t> numbers) {
    P min = positions[numbers[0]], max = min;
    for (const std::uint32_t i : numbers) {
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) {
            along(min, axis) = std::min(along(min, axis), along(positions[i], axis));
            along(max, axis) = std::max(along(max, axis), along(positions[i], axis));
        }
    }
    const P size = max - min;
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < kAxes<P>; ++axis) {
        if (along(size, axis) >= along(size, longest)) longest = axis;
    }
    return longest;
}

/// Regions with nearly equal numbers of points, made by recursive halving. Regions lose points in turn.
class Regions {
public:
    /// Sorts points by region.
    /// @param order  permutation of the points; reordered such that the points of each region are successive, in
    ///               ascending order
    template <class P>
    Regions(std::span<const P> positions, std::vector<std::uint32_t>& order) {
        while ((order.size() >> depth_) >= 2 * kMinRegionPoints) ++depth_;
        sizes_.resize(std::size_t{2} << depth_);
        divide(positions, order, 1, 0);
        remaining_ = sizes_;
    }

    /// Returns the depth at which regions have enough points to choose from, if `remaining` points remain in the
    /// domain.
    int depth(std::size_t remaining) const {
        int depth = 0;
        while (depth < depth_ && (remaining >> (depth + 1)) >= kMinRegionPoints) ++depth;
        return depth;
    }

    /// Returns the number of remaining points in each region of a depth.
    std::span<const std::uint32_t> remaining(int depth) const {
        const std::size_t count = std::size_t{1} << depth;
        return std::span(remaining_).subspan(count, count);
    }

    /// Returns the region of a depth that loses the next point: at each level, the half with the larger share of
    /// remaining points.
    std::size_t next_region(int depth) const {
        std::size_t region = 1;
        for (int i = 0; i < depth; ++i) {
            const std::size_t first = 2 * region, second = first + 1;
            const std::uint64_t a = std::uint64_t{remaining_[first]} * sizes_[second];
            const std::uint64_t b = std::uint64_t{remaining_[second]} * sizes_[first];
            region = a > b || (a == b && is_first(region)) ? first : second;
        }
        return region - (std::size_t{1} << depth);
    }

    /// Counts the removal of a point from a region of a depth, whether or not the region was the next in turn.
    void count_removal(int depth, std::size_t region) {
        for (region += std::size_t{1} << depth; region > 0; region /= 2) --remaining_[region];
    }

private:
    /// Chooses pseudo-randomly between two halves with equal shares, so that neither loses points systematically.
    bool is_first(std::size_t region) const {
        std::uint64_t bits = (std::uint64_t{region} << 32 | remaining_[region]) * 0x9e3779b97f4a7c15;
        bits = (bits ^ bits >> 32) * 0xd6e8feb86659fd93;
        return (bits >> 63) != 0;
    }

    template <class P>
    void divide(std::span<const P> positions, std::span<std::uint32_t> order, std::size_t region, int depth) {
        sizes_[region] = static_cast<std::uint32_t>(order.size());
        // nth_element() leaves points in an order that depends on the standard library.
        if (depth == depth_) {
            std::ranges::sort(order);
            return;
        }
        const std::size_t axis = longest_axis<P>(positions, order);
        const auto position = [&](std::uint32_t i) { return along(positions[i], axis); };
        const std::size_t half = order.size() / 2;
        std::ranges::nth_element(
            order, order.begin() + static_cast<std::ptrdiff_t>(half),
            [&](std::uint32_t i, std::uint32_t j) { return std::pair(position(i), i) < std::pair(position(j), j); });
        divide(positions, order.first(half), 2 * region, depth + 1);
        divide(positions, order.subspan(half), 2 * region + 1, depth + 1);
    }

    int depth_ = 0;
    std::vector<std::uint32_t> sizes_;  ///< [2 << depth_] initial points; the halves of region i are 2 i and 2 i + 1
    std::vector<std::uint32_t> remaining_;  ///< [2 << depth_] remaining points
};

}  // namespace ccdt::ordering
