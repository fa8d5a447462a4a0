// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ccdt/volume/voxel_density.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// The zones of a density on voxels (find_zones()).
class VoxelZones {
public:
    /// @param density   must outlive this object
    /// @param periodic  whether the first and the last voxels along an axis are neighbours
    /// @param sites     number of sites in the box of the density
    VoxelZones(const VoxelDensity& density, bool periodic, double sites);

    std::size_t count() const { return classes_.size(); }
    /// Returns the zone at a position, given relative to the sides of the box.
    std::uint32_t at(Point3 p) const { return zones_.empty() ? 0 : zones_[density_.voxel_at(p)]; }

    /// Returns the number of classes. All zones of a class have about the same density.
    std::size_t classes() const { return class_count_; }
    std::size_t class_of(std::uint32_t zone) const { return classes_[zone]; }

private:
    void find_classes(std::span<const float> values);

    const VoxelDensity& density_;
    std::vector<std::uint32_t> zones_;         ///< [voxels] empty if there is one zone
    std::vector<std::uint8_t> classes_ = {0};  ///< [count()]
    std::size_t class_count_ = 1;
};

}  // namespace ccdt
