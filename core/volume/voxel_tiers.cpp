// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/voxel_tiers.h"

#include <algorithm>
#include <utility>

#include "core/density/tiers.h"

namespace ccdt {

VoxelTiers::VoxelTiers(const VoxelDensity& density, bool periodic, double sites) : density_(density) {
    if (density.is_uniform()) return;
    const auto cells = density.voxels();
    const std::size_t all = cells[0] * cells[1] * cells[2];
    const double scale = static_cast<double>(all) / density.largest();
    DensityHistogram histogram;
    histogram.bins.reserve(all);
    for (std::size_t i = 0; i < all; ++i) {
        const Box3 voxel = cell_box(cells, i);
        histogram.add(density.is_positive(0.5 * (voxel.min + voxel.max)) ? scale * density.mass(voxel) : 0);
    }
    tiers_ = find_tiers(std::move(histogram), cells, periodic, sites);
    if (!tiers_.empty()) count_ = std::size_t{std::ranges::max(tiers_)} + 1;
}

}  // namespace ccdt
