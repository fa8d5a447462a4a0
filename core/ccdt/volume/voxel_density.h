// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/axes.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Wanted density of points in a box or a torus, up to a factor. It is constant in each voxel of a grid. Coordinates
/// are relative to the domain's sides, hence in [0, 1].
class VoxelDensity {
public:
    static VoxelDensity uniform() { return {}; }

    /// Makes a density. It is uniform() if all values are equal.
    /// @param voxels  number of voxels along x, y and z, each >= 1
    /// @param values  [voxels along z][along y][along x] densities, >= 0 and finite
    ///                Values below 2^-52 of the largest count as 0.
    ///
    /// Errors: Malformed if the number of values is wrong ("density"), or a value is negative or not finite
    /// ("density/N"); Unusable if all are 0 ("density"). O(voxels). Takes 8 bytes per corner of the voxels.
    static Result<VoxelDensity> create(const std::array<std::size_t, 3>& voxels, std::span<const double> values);

    /// Checks the values of voxels, without making a density. Returns whether all are equal.
    /// @param voxels  as for create(); their product must not overflow
    /// @param value   returns the value with an index
    /// Errors: as for create(), except for a wrong number of values.
    static Result<bool> check(const std::array<std::size_t, 3>& voxels,
                              const std::function<double(std::size_t index)>& value);

    bool is_uniform() const { return sums_.empty(); }

    /// Returns the density at a point, relative to the mean density.
    double at(Point3 p) const;

    /// Whether the density is 0 in any voxel.
    bool has_gaps() const { return !positive_.empty(); }
    /// Whether the density at a point is > 0.
    bool is_positive(Point3 p) const;

    /// Returns the share of the total mass in a box.
    /// @param box  within [0, 1]^3
    double mass(const Box3& box) const;

    /// Returns the coordinate of the plane below which a box has a share of its mass or, if its mass is 0, of its
    /// volume. O(log voxels).
    /// @param axis   0, 1 or 2: the plane is perpendicular to x, y or z
    /// @param share  in (0, 1)
    double cut(const Box3& box, std::size_t axis, double share) const;

    /// Draws a point in a box with the density as probability.
    /// @param shares  three random numbers in (0, 1)
    Point3 draw(Box3 box, const std::array<double, 3>& shares) const;

    /// Returns the mean of the density over all points of a pattern with this density, relative to the mean over the
    /// volume; 1 if the density is uniform.
    double contrast() const { return contrast_; }
    /// Returns the largest density, relative to the mean density.
    double largest() const { return largest_; }
    /// Returns the numbers of voxels along x, y and z; all 1 if the density is uniform.
    const std::array<std::size_t, 3>& voxels() const { return voxels_; }
    /// Returns the number of the voxel that contains a point, counted along x, then y, then z.
    std::size_t voxel_at(Point3 p) const {
        return (voxel(p.z, 2) * voxels_[1] + voxel(p.y, 1)) * voxels_[0] + voxel(p.x, 0);
    }
    double voxel_count() const { return static_cast<double>(voxels_[0] * voxels_[1] * voxels_[2]); }

private:
    /// A coordinate: the number of its voxel, and the position in the voxel, in [0, 1].
    struct Position {
        std::size_t first;
        double part;
    };
    Position position(double v, std::size_t axis) const;
    double sum(Position x, Position y, Position z) const;
    std::size_t voxel(double v, std::size_t axis) const;

    std::array<std::size_t, 3> voxels_{1, 1, 1};
    double contrast_ = 1, largest_ = 1;
    /// [layers + 1][rows + 1][columns + 1] share of the mass between the origin and each corner of the voxels; empty if
    /// uniform.
    std::vector<double> sums_;
    std::vector<bool> positive_;  ///< [voxels] whether the density is > 0; empty if it is > 0 everywhere
};

/// Returns a cell of a grid over the unit cube.
/// @param cells   number of cells along x, y and z
/// @param number  number of the cell, counted along x, then y, then z
Box3 cell_box(const std::array<std::size_t, 3>& cells, std::size_t number);

}  // namespace ccdt
