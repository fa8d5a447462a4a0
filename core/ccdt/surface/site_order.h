// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/surface/surface_triangulation.h"

namespace ccdt {

/// An order in which free sites of a mesh are moved, many of them in parallel. The result does not depend on the number
/// of threads. Each site belongs to the smallest block that contains it and its free neighbours. The sites of a block
/// are moved one after another, and the blocks of a level in parallel. Levels follow each other, from small blocks to
/// large blocks.
class SiteOrder {
public:
    /// Computes the order of the sites that `moves` accepts. It is valid until edges change. O(sites).
    template <class Moves>
    SiteOrder(const SurfaceTriangulation& mesh, Moves&& moves) : mesh_(mesh) {
        const SiteBlocks& blocks = mesh.blocks();
        for (int level = 0; level < blocks.levels(); ++level) levels_.emplace_back(blocks.count(level));
        constexpr std::size_t kSites = 1024;  // per task
        std::vector<SiteBlocks::Block> block_of(mesh.free_count(), {kNone, 0});
        for_ranges(mesh.executor(), mesh.free_count(), kSites, [&](std::size_t begin, std::size_t end) {
            for (auto site = static_cast<std::uint32_t>(begin); site < end; ++site) {
                if (!moves(site)) continue;
                const std::uint32_t number = blocks.of(site);
                std::uint32_t apart = 0;
                mesh.for_edges(site, [&](std::uint32_t h) {
                    for (const std::uint32_t other : {mesh.target(h), mesh.origin(SurfaceTriangulation::previous(h))}) {
                        if (mesh.is_free(other)) apart |= blocks.of(other) ^ number;
                    }
                });
                block_of[site] = blocks.block(number, apart);
            }
        });
        for (std::uint32_t site = 0; site < block_of.size(); ++site) {
            const auto [level, number] = block_of[site];
            if (level != kNone) levels_[static_cast<std::size_t>(level)][number].push_back(site);
        }
    }

    /// Calls function(site) for each site. The function may move the site and read its neighbours. A stop skips the
    /// blocks that have not begun.
    template <class Function>
    void for_sites(const std::stop_token& stop, Function&& function) const {
        for (const auto& blocks : levels_) {
            mesh_.executor().run(blocks.size(), [&](std::size_t block) {
                if (stop.stop_requested()) return;
                const auto& sites = blocks[block];
                for (std::size_t i = 0; i < sites.size(); ++i) {
                    if (i + kAhead < sites.size()) mesh_.surface().prefetch(mesh_.on_surface(sites[i + kAhead]).face);
                    function(sites[i]);
                }
            });
        }
    }

private:
    static constexpr int kNone = -1;          ///< level of sites that do not move
    static constexpr std::size_t kAhead = 4;  ///< sites whose faces are loaded before they are moved

    const SurfaceTriangulation& mesh_;
    std::vector<std::vector<std::vector<std::uint32_t>>> levels_;  ///< [levels][blocks] sites
};

}  // namespace ccdt
