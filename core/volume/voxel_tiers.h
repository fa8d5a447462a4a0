// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/point3.h"
#include "core/volume/voxel_density.h"

namespace ccdt {

/// The tiers of a density on voxels: a place is in tier k if its density is above k of the steps of the density
/// (find_tiers()).
class VoxelTiers {
public:
    /// @param density   must outlive this object
    /// @param periodic  whether the first and the last voxels along an axis are neighbours
    /// @param sites     number of sites in the box of the density
    VoxelTiers(const VoxelDensity& density, bool periodic, double sites);

    /// Number of tiers; 1 if the density has no steps.
    std::size_t count() const { return count_; }
    /// Returns the tier of a place, given relative to the sides of the box.
    std::size_t at(Point3 p) const { return tiers_.empty() ? 0 : tiers_[density_.voxel_at(p)]; }

private:
    const VoxelDensity& density_;
    std::size_t count_ = 1;
    std::vector<std::uint8_t> tiers_;  ///< [voxels] empty if the density has no steps
};

}  // namespace ccdt
