// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// A set of points with a least distance between them, which bounds the number of points in any area.
class ThinnedPoints {
public:
    /// @param apart  least distance, > 0, in the unit frame
    ThinnedPoints(const Domain& domain, double apart)
        : torus_(domain.is_torus()), sides_(domain.unit_bounds().max), apart_(apart) {
        if (torus_) columns_ = cells(sides_.x), rows_ = cells(sides_.y);
    }

    /// Returns the index of a point of the set that is closer to p than the least distance, if there is one.
    std::optional<std::size_t> near(Point p) const {
        const auto [column, row] = cell_of(p);
        for (std::int64_t j = row - 1; j <= row + 1; ++j) {
            for (std::int64_t i = column - 1; i <= column + 1; ++i) {
                const auto [first, last] = numbers_.equal_range(key(i, j));
                for (auto each = first; each != last; ++each) {
                    Point off = points_[each->second] - p;
                    if (torus_) off = {std::remainder(off.x, sides_.x), std::remainder(off.y, sides_.y)};
                    if (dot(off, off) < apart_ * apart_) return each->second;
                }
            }
        }
        return std::nullopt;
    }

    void add(Point p) {
        const auto [column, row] = cell_of(p);
        numbers_.emplace(key(column, row), points_.size());
        points_.push_back(p);
    }

    std::vector<Point> take() && { return std::move(points_); }

private:
    /// Returns the number of cells along a side of a torus; no cell is smaller than the least distance.
    std::int64_t cells(double side) const {
        return std::max(std::int64_t{1}, static_cast<std::int64_t>(side / apart_));
    }

    std::pair<std::int64_t, std::int64_t> cell_of(Point p) const {
        const auto cell = [this](double position, double side, std::int64_t cells) {
            return static_cast<std::int64_t>(
                std::floor(torus_ ? position / side * static_cast<double>(cells) : position / apart_));
        };
        return {cell(p.x, sides_.x, columns_), cell(p.y, sides_.y, rows_)};
    }

    std::uint64_t key(std::int64_t column, std::int64_t row) const {
        if (torus_) column = (column + columns_) % columns_, row = (row + rows_) % rows_;
        return static_cast<std::uint64_t>(column) << 32 ^ (static_cast<std::uint64_t>(row) & 0xffffffff);
    }

    bool torus_;
    Point sides_;
    double apart_;
    std::int64_t columns_ = 1, rows_ = 1;
    std::vector<Point> points_;
    std::unordered_multimap<std::uint64_t, std::size_t> numbers_;  ///< keyed by cell
};

}  // namespace ccdt
