// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/solid_domain.h"
#include "core/ccdt/volume/volume_spacing.h"
#include "core/ccdt/volume/voxel_density.h"
#include "core/geometry/delaunay3.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Moves sites in space such that the capacities of the tetrahedra in their Delaunay triangulation become more equal,
/// as Relaxation does in the plane. They cannot all be equal: there are three coordinates, but about six tetrahedra,
/// per site.
///
/// The domain is divided into blocks, as by a k-d tree: planes divide the sites in two until no block has more
/// than 10,000. Each block is triangulated separately, together with the sites around it and with copies of sites
/// beyond the domain's border. So blocks can be processed in parallel, and only the triangulations of a few blocks are
/// in memory at a time. While a block is relaxed, the sites around it keep their positions. In every second call, the
/// first planes divide the sites 40 : 60, so that the blocks have other borders.
/// @tparam Domain  BoxDomain3 or SolidDomain
template <class Domain>
class BlockRelaxation {
public:
    /// @param density, spacing  must outlive this object
    BlockRelaxation(const Domain& domain, const VoxelDensity& density, const VolumeSpacing& spacing, Executor& executor)
        : domain_(domain), density_(density), spacing_(spacing), executor_(executor) {}

    /// Triangulates the sites and moves each of them `passes` times.
    /// @param sites  in the domain; the first `free` of them move
    /// @param stop   polled regularly; a stop leaves the sites where they are
    /// @returns      the capacity variation of the tetrahedra before the moves: standard deviation over mean; 0 after a
    ///               stop
    ///
    /// The result does not depend on the number of threads. O(sites log sites). A triangulation takes about 500 bytes
    /// per site of a block and per site around it.
    double relax(std::span<Point3> sites, std::size_t free, int passes, const std::stop_token& stop);

private:
    /// A site or a copy near a block.
    struct Neighbour {
        Point3 position;
        float reach;  ///< it is near all blocks that are at most this far away along each axis
    };
    struct Block {
        std::vector<std::uint32_t> own;  ///< numbers of the block's sites
        std::vector<Neighbour> near;
    };
    /// Sums over tetrahedra.
    struct Sums {
        double count = 0, first = 0, second = 0;
    };

    std::vector<Block> divide(std::span<const Point3> sites) const;
    void divide(Block block, std::span<const Point3> sites, std::size_t most, int odd_planes,
                std::vector<Block>& blocks) const;
    Sums relax_block(const Block& block, std::span<const Point3> sites, std::size_t free, int passes,
                     std::span<Point3> moved, const std::stop_token& stop) const;

    Domain domain_;
    const VoxelDensity& density_;
    const VolumeSpacing& spacing_;
    Executor& executor_;
    std::size_t calls_ = 0;
};

extern template class BlockRelaxation<BoxDomain3>;
extern template class BlockRelaxation<SolidDomain>;

}  // namespace ccdt
