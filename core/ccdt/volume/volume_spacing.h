// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/voxel_density.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// The local spacing of points: the side of the cube around a position that holds one of the wanted points. If the
/// density varies, sides are computed on a grid and interpolated. If the interpolated side is much too long for a voxel
/// with many points, the spacing follows from the density of the voxel alone.
class VolumeSpacing {
public:
    /// Largest distance at which another site pushes a site, relative to the site's own reach. It is a limit only where
    /// the spacing changes by more than a factor of 2 between neighbours.
    static constexpr double kMaxRatio = 1.5;

    /// @param density  must outlive this object
    /// @param points   number of points in the domain, >= 1
    /// @param stop     polled regularly; after a stop, the spacing is undefined
    ///
    /// With uniform density, O(1). Otherwise, O(points), with at most 200 cells along each axis of the grid.
    VolumeSpacing(const BoxDomain3& domain, const VoxelDensity& density, std::size_t points, Executor& executor,
                  const std::stop_token& stop = {});

    bool is_uniform() const { return sides_.empty(); }
    double mean() const { return mean_; }  ///< the spacing if the density were uniform

    /// Returns the spacing at a position in the domain, > 0. It is at most the cubic root of the domain's volume, and
    /// has this value where the density is 0 all around.
    double side(Point3 p) const;

    /// Returns the distance of neighbours in the densest packing with the local density.
    double densest(Point3 p) const { return kDensest * side(p); }

    /// Distance of neighbours in the densest packing with one point per unit of volume.
    static constexpr double kDensest = kCubicSpacing;

private:
    double mean_;
    Point3 domain_sides_;
    std::array<std::size_t, 3> cells_{};
    const VoxelDensity* crowded_ = nullptr;  ///< the density, if a voxel has many points
    double many_ = 0;                        ///< density of a voxel with many points, relative to the mean density
    std::vector<float> sides_;  ///< [z][y][x] sides at the centres of cells; empty if the density is uniform
};

}  // namespace ccdt
