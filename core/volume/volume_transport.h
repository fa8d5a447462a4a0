// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point3.h"
#include "core/parallel/executor.h"
#include "core/volume/box_domain3.h"
#include "core/volume/solid_domain.h"
#include "core/volume/volume_spacing.h"
#include "core/volume/voxel_density.h"
#include "core/volume/wave_grid.h"

namespace ccdt {

/// Removes long waves of density error from points in space. Works like Transport in the plane, where the derivation
/// is. Differences: the filter for a uniform density is sharp, which leaves larger distances between points; and each
/// octave has its own grid, because the moves of all octaves are added up.
/// @tparam Domain  BoxDomain3 or SolidDomain
template <class Domain>
class VolumeTransport {
public:
    /// @param density  over the bounding box of the domain; in a solid, 0 outside
    /// @param spacing  must outlive this object
    /// @param points   number of sites and fixed points
    /// @param precise  whether the grid is precise enough to reduce power to -100 dB, which takes more than twice the
    ///                 memory
    /// @param stop     polled regularly; after a stop, the transport must not be used
    VolumeTransport(const Domain& domain, const VoxelDensity& density, const VolumeSpacing& spacing, std::size_t points,
                    bool precise, Executor& executor, const std::stop_token& stop = {});

    /// Moves sites such that the error of density in long waves vanishes to first order. No move is longer than a
    /// quarter of the spacing.
    /// @param sites  [points] in the domain; the first `free` of them move
    /// @param stop   polled between the steps; a stop leaves the sites where they are
    /// @returns      the largest power of a removed wave before the moves, relative to the power of random points; 0 if
    ///               the density varies, or after a stop
    double even_out(std::span<Point3> sites, std::size_t free, const std::stop_token& stop);

    /// Releases most of the memory until the next call of even_out().
    void release_memory();

private:
    struct Octave {
        WaveGrid grid;
        double spacing;
        std::vector<float> target = {};  ///< [cells] wanted density, spread like sites; empty if it is uniform
    };

    double level(Point3 p) const;
    void set_target(Octave& octave, std::size_t number, const VoxelDensity& density, const std::stop_token& stop);
    double solve(Octave& octave);

    Domain domain_;
    const VolumeSpacing& spacing_;
    Executor& executor_;
    double points_;
    double finest_;  ///< spacing of octave 0
    std::vector<Octave> octaves_;
    std::vector<double> weights_;  ///< [points] weights of the sites in an octave
    std::vector<Point3> moves_;
};

extern template class VolumeTransport<BoxDomain3>;
extern template class VolumeTransport<SolidDomain>;

}  // namespace ccdt
