// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ccdt/maps/feature_area.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Finds the features at a position. Uses a grid with about one cell per feature, or fewer, so that a bounding box
/// overlaps at most eight cells on average.
class FeatureIndex {
public:
    /// @param areas  [n >= 1]; must outlive this
    explicit FeatureIndex(std::span<const FeatureArea> areas);

    /// Calls function(number) for each feature whose bounding box may contain the position.
    template <class Function>
    void for_near(Point p, Function&& function) const {
        const std::size_t cell = row(p.y) * columns_ + column(p.x);
        for (std::size_t i = first_[cell]; i < first_[cell + 1]; ++i) function(members_[i]);
    }

private:
    std::size_t column(double x) const { return index((x - box_.min.x) / box_.width(), columns_); }
    std::size_t row(double y) const { return index((y - box_.min.y) / box_.height(), rows_); }
    static std::size_t index(double share, std::size_t cells);
    std::size_t count_members(std::span<const FeatureArea> areas) const;
    template <class Visit>
    void for_cells(const Box& box, Visit visit) const;

    Box box_;
    std::size_t columns_ = 1, rows_ = 1;
    std::vector<std::size_t> first_;  ///< [cells + 1] start of each cell's list in `members_`
    std::vector<std::uint32_t> members_;
};

}  // namespace ccdt
