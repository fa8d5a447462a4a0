// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/choice/candidate_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/elementary.h"
#include "core/geometry/axes.h"
#include "core/geometry/morton.h"

namespace ccdt::choice {

namespace {

/// Resolution of Morton positions along each axis.
constexpr int kBits = 21;
constexpr double kResolution = 0x1p21;

/// Mean number of cubes of side 1 that a surface meets per unit of area, over all directions.
constexpr double kCubesPerArea = 1.5;

constexpr std::size_t kRange = 16'384;  ///< candidates per task

}  // namespace

CandidateCells::CandidateCells(std::span<const Point3> positions, Point3 sides, Extent extent, double wanted,
                               Executor& executor)
    : positions_(positions), sides_(sides), keys_(positions.size()), rows_(positions.size()) {
    sort([](Point3 p) { return morton_position(p); }, executor);
    const double side = side_of_cells(wanted);
    set_grid(side);
    const double unit = elementary::exp2(fine_bits_ - kBits);
    const double inside = 1 - elementary::exp2(-fine_bits_ - 1);  // keeps the box's last face in the last cells
    sort(
        [&](Point3 p) {
            return morton_position(by_axis<Point3>([&](std::size_t axis) {
                const double length = along(sides_, axis), count = along(counts_, axis);
                return length > 0 ? std::min(along(p, axis) / length * count, count - 1 + inside) * unit : 0;
            }));
        },
        executor);
    for (std::size_t begin = 0, end = 0; begin < keys_.size(); begin = end) {
        while (end < keys_.size() && keys_[end] >> (3 * fine_bits_) == keys_[begin] >> (3 * fine_bits_)) ++end;
        cells_.push_back({begin, end});
    }
    size_ = 1;
    for (std::size_t axis = 0; axis < (extent == Extent::Plane ? 2 : 3); ++axis)
        size_ *= along(sides_, axis) > 0 ? along(sides_, axis) / along(counts_, axis) : side;
    if (extent == Extent::Surface) size_ = elementary::cbrt(size_) * elementary::cbrt(size_) / kCubesPerArea;
}

template <class Key>
void CandidateCells::sort(Key&& key, Executor& executor) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed(positions_.size());
    for_ranges(executor, keyed.size(), kRange, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) keyed[i] = {key(positions_[i]), static_cast<std::uint32_t>(i)};
    });
    std::ranges::sort(keyed);
    for (std::size_t i = 0; i < keyed.size(); ++i) keys_[i] = keyed[i].first, rows_[i] = keyed[i].second;
}

/// Interpolates between the grids with cells of side 1, 1/2, 1/4, ...
double CandidateCells::side_of_cells(double wanted) const {
    std::array<std::size_t, kBits + 1> occupied{};
    occupied.fill(1);
    for (std::size_t i = 1; i < keys_.size(); ++i) {
        const std::uint64_t differing = keys_[i] ^ keys_[i - 1];
        for (int level = kBits; level > 0 && differing >> (3 * (kBits - level)) != 0; --level)
            ++occupied[static_cast<std::size_t>(level)];
    }
    std::size_t level = 1;
    while (level < kBits && static_cast<double>(occupied[level]) < wanted) ++level;
    const auto coarse = static_cast<double>(occupied[level - 1]), fine = static_cast<double>(occupied[level]);
    const double part =
        fine > coarse ? std::min(1.0, elementary::log(wanted / coarse) / elementary::log(fine / coarse)) : 1;
    return elementary::exp2(1 - static_cast<double>(level) - part);
}

void CandidateCells::set_grid(double side) {
    double most = 1;
    finest_ = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        along(counts_, axis) = std::clamp(std::round(along(sides_, axis) / side), 1.0, kResolution);
        most = std::max(most, along(counts_, axis));
    }
    while (most * 2 <= kResolution) most *= 2, ++fine_bits_;
    for (std::size_t axis = 0; axis < 3; ++axis)
        finest_ = std::max(finest_, along(sides_, axis) / along(counts_, axis) * elementary::exp2(-fine_bits_));
}

Point3 CandidateCells::centre(const Range& cell) const {
    const Point3 p = positions_[rows_[cell.begin]];
    return by_axis<Point3>([&](std::size_t axis) {
        const double length = along(sides_, axis), count = along(counts_, axis);
        if (length == 0) return 0.0;
        return (std::min(std::floor(along(p, axis) / length * count), count - 1) + 0.5) * length / count;
    });
}

std::vector<CandidateCells::Range> CandidateCells::blocks() const {
    constexpr int kBlockBits = 2;
    const int shift = 3 * std::min(fine_bits_ + kBlockBits, kBits);
    std::vector<Range> blocks;
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
        const auto block_of = [&](const Range& each) { return keys_[each.begin] >> shift; };
        if (cell > 0 && block_of(cells_[cell]) == block_of(cells_[cell - 1]))
            ++blocks.back().end;
        else
            blocks.push_back({cell, cell + 1});
    }
    return blocks;
}

CandidateCells::Range CandidateCells::small_cell(std::size_t begin, double side) const {
    const double parts = std::clamp(side / std::max(finest_, 1 / kResolution), 1.0, kResolution);
    const int shift = 3 * static_cast<int>(elementary::log2(parts));
    std::size_t end = begin;
    while (end < keys_.size() && keys_[end] >> shift == keys_[begin] >> shift) ++end;
    return {begin, end};
}

}  // namespace ccdt::choice
