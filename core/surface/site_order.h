// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/surface/surface_triangulation.h"

namespace ccdt {

/// An order in which free sites of a mesh are moved, many of them in parallel. The result does not depend on the
/// number of threads. Each site belongs to the smallest block that contains it and its free neighbours. The sites
/// of a block are moved one after another, the blocks of a level in parallel, and the levels from small blocks to large
/// ones.
class SiteOrder {
public:
    /// Computes the order of the sites that `moves` accepts. It is valid until edges change. O(sites).
    template <class Moves>
    SiteOrder(const SurfaceTriangulation& mesh, Moves&& moves) : executor_(mesh.executor()) {
        const SiteBlocks& blocks = mesh.blocks();
        for (int level = 0; level < blocks.levels(); ++level) levels_.emplace_back(blocks.count(level));
        for (std::uint32_t site = 0; site < mesh.free_count(); ++site) {
            if (!moves(site)) continue;
            const std::uint32_t number = blocks.of(site);
            std::uint32_t apart = 0;
            mesh.for_edges(site, [&](std::uint32_t h) {
                for (const std::uint32_t other : {mesh.target(h), mesh.origin(SurfaceTriangulation::previous(h))}) {
                    if (mesh.is_free(other)) apart |= blocks.of(other) ^ number;
                }
            });
            const SiteBlocks::Block block = blocks.block(number, apart);
            levels_[static_cast<std::size_t>(block.level)][block.number].push_back(site);
        }
    }

    /// Calls function(site) for each site. The function may move the site and read its neighbours. A stop skips the
    /// blocks that have not begun.
    template <class Function>
    void for_sites(const std::stop_token& stop, Function&& function) const {
        for (const auto& blocks : levels_) {
            executor_.run(blocks.size(), [&](std::size_t block) {
                if (stop.stop_requested()) return;
                for (const std::uint32_t site : blocks[block]) function(site);
            });
        }
    }

private:
    Executor& executor_;
    std::vector<std::vector<std::vector<std::uint32_t>>> levels_;  ///< [levels][blocks] sites
};

}  // namespace ccdt
