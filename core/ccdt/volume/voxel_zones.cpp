// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/voxel_zones.h"

#include <algorithm>
#include <functional>

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
    if (!zones_.empty()) find_classes(values);
}

/// Groups the zones by their mean densities.
void VoxelZones::find_classes(std::span<const float> values) {
    const std::size_t count = std::size_t{std::ranges::max(zones_)} + 1;
    std::vector<double> densities(count), voxels(count);
    for (std::size_t i = 0; i < zones_.size(); ++i) {
        densities[zones_[i]] += static_cast<double>(values[i]);
        ++voxels[zones_[i]];
    }
    std::ranges::transform(densities, voxels, densities.begin(), std::divides{});
    const auto classes = group_into_classes(densities);
    class_count_ = classes.size();
    classes_.resize(count);
    for (std::size_t number = 0; number < classes.size(); ++number) {
        for (const std::uint32_t zone : classes[number]) classes_[zone] = static_cast<std::uint8_t>(number);
    }
}

}  // namespace ccdt
