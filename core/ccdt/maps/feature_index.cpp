// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/feature_index.h"

#include <algorithm>
#include <cmath>

namespace ccdt {

FeatureIndex::FeatureIndex(std::span<const FeatureArea> areas) : box_(areas.front().bounds()) {
    for (const FeatureArea& area : areas) {
        box_.include(area.bounds().min);
        box_.include(area.bounds().max);
    }
    constexpr double kMin = 1, kMax = 4096;
    const double cells = static_cast<double>(areas.size()), shape = std::sqrt(box_.width() / box_.height());
    columns_ = static_cast<std::size_t>(std::clamp(std::sqrt(cells) * shape, kMin, kMax));
    rows_ = static_cast<std::size_t>(std::clamp(std::sqrt(cells) / shape, kMin, kMax));
    constexpr std::size_t kEach = 8;
    while (columns_ * rows_ > 1 && count_members(areas) > kEach * areas.size()) {
        columns_ = (columns_ + 1) / 2;
        rows_ = (rows_ + 1) / 2;
    }
    first_.assign(columns_ * rows_ + 1, 0);
    for (const FeatureArea& area : areas) for_cells(area.bounds(), [&](std::size_t cell) { ++first_[cell + 1]; });
    for (std::size_t cell = 0; cell + 1 < first_.size(); ++cell) first_[cell + 1] += first_[cell];
    members_.resize(first_.back());
    auto next = first_;
    for (std::uint32_t i = 0; i < areas.size(); ++i)
        for_cells(areas[i].bounds(), [&](std::size_t cell) { members_[next[cell]++] = i; });
}

std::size_t FeatureIndex::index(double share, std::size_t cells) {
    const double last = static_cast<double>(cells) - 1;
    return static_cast<std::size_t>(std::clamp(std::floor(share * static_cast<double>(cells)), 0.0, last));
}

std::size_t FeatureIndex::count_members(std::span<const FeatureArea> areas) const {
    std::size_t count = 0;
    for (const FeatureArea& area : areas) {
        const Box& box = area.bounds();
        count += (row(box.max.y) - row(box.min.y) + 1) * (column(box.max.x) - column(box.min.x) + 1);
    }
    return count;
}

template <class Visit>
void FeatureIndex::for_cells(const Box& box, Visit visit) const {
    for (std::size_t j = row(box.min.y); j <= row(box.max.y); ++j) {
        for (std::size_t i = column(box.min.x); i <= column(box.max.x); ++i) visit(j * columns_ + i);
    }
}

}  // namespace ccdt
