// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/voxel_zones.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include "core/density/zones.h"

namespace ccdt {

VoxelZones::VoxelZones(const VoxelDensity& density, bool periodic, double sites) : density_(density) {
    if (density.is_uniform()) return;
    const auto voxels = density.voxels();
    const std::size_t all = voxels[0] * voxels[1] * voxels[2];
    std::vector<float> values;
    values.reserve(all);
    for (std::size_t i = 0; i < all; ++i) {
        const Box3 voxel = cell_box(voxels, i);
        const bool is_positive = density.is_positive(0.5 * (voxel.min + voxel.max));
        values.push_back(is_positive ? static_cast<float>(static_cast<double>(all) * density.mass(voxel)) : 0);
    }
    zones_ = find_zones(voxels, values, periodic, sites);
    if (!zones_.empty()) sort_into_classes(values);
}

/// Puts zones into one class whose mean densities follow each other closely.
void VoxelZones::sort_into_classes(std::span<const float> values) {
    constexpr double kSame = 1.2;  // largest ratio of successive densities of one class
    constexpr std::size_t kMaxClasses = 16;
    const std::size_t count = std::size_t{std::ranges::max(zones_)} + 1;
    std::vector<double> densities(count), voxels(count);
    for (std::size_t i = 0; i < zones_.size(); ++i) {
        densities[zones_[i]] += static_cast<double>(values[i]);
        ++voxels[zones_[i]];
    }
    std::ranges::transform(densities, voxels, densities.begin(), std::divides{});
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t zone) { return densities[zone]; });
    classes_.assign(count, 0);
    double last = densities[order.front()];
    for (const std::uint32_t zone : order) {
        if (densities[zone] > kSame * last && class_count_ < kMaxClasses) ++class_count_;
        classes_[zone] = static_cast<std::uint8_t>(class_count_ - 1);
        last = densities[zone];
    }
}

}  // namespace ccdt
