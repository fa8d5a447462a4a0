// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/executor.h"
#include "core/mesh/site_blocks.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// The part of the mesh that one task may change: the triangles with all vertices in one block.
struct Region {
    /// A site still to be inserted.
    struct Site {
        std::uint32_t number = 0;  ///< index in the list of sites to insert
        /// Triangle at which the search for the site's position left a smaller region; kNone before the first search.
        std::uint32_t triangle = Triangulation::kNone;
    };

    std::uint32_t first = 0;                    ///< first vertex of the block
    std::uint32_t size = Triangulation::kNone;  ///< number of vertices; kNone: the whole mesh
    std::uint32_t last = Triangulation::kNone;  ///< a triangle of the region, near the last insertion
    std::vector<std::uint32_t> stack;           ///< edges that may not be Delaunay
    std::vector<std::uint32_t> edges;           ///< edges left for a larger region
    std::vector<Site> sites;                    ///< sites to insert; afterwards the sites left for a larger region
    std::size_t flips = 0;

    bool has(std::uint32_t vertex) const { return vertex - first < size; }
    bool is_whole() const { return size == Triangulation::kNone; }
};

/// The regions of all levels of blocks.
class Regions {
public:
    /// @param sites  least number of sites per block; levels with smaller blocks are left out
    Regions(const SiteBlocks& blocks, std::size_t sites) {
        while (first_level_ < blocks.last_level() && blocks.sites() / blocks.count(first_level_) < sites)
            ++first_level_;
        for (int level = first_level_; level < blocks.last_level(); ++level) {
            auto& regions = levels_.emplace_back(blocks.count(level));
            const std::size_t of_each = blocks.count(0) / regions.size();
            for (std::size_t number = 0; number < regions.size(); ++number) {
                regions[number].first = blocks.begin(number * of_each);
                regions[number].size = blocks.begin((number + 1) * of_each) - regions[number].first;
            }
        }
        levels_.emplace_back(1);
    }

    /// Returns the region of the last level, which is the whole mesh.
    Region& whole() { return levels_.back().front(); }

    /// Returns the region responsible for a block.
    Region& of(SiteBlocks::Block block) {
        const int higher = std::max(0, first_level_ - block.level);
        const auto level = static_cast<std::size_t>(block.level + higher - first_level_);
        return level + 1 >= levels_.size() ? whole() : levels_[level][block.number >> 2 * higher];
    }

    /// Processes the regions level by level. All regions of a level are processed in parallel, and their unfinished
    /// work is passed on to the regions of the next level. Must be called only once.
    /// @param work  called with each region
    /// @returns     the region of the last level
    template <class Work>
    Region process(Executor& executor, Work&& work) {
        for (std::size_t level = 0;; ++level) {
            std::vector<Region>& small = levels_[level];
            executor.run(small.size(), [&](std::size_t number) { work(small[number]); });
            if (level + 1 == levels_.size()) return std::move(small.front());
            std::vector<Region>& large = levels_[level + 1];
            for (std::size_t number = 0; number < small.size(); ++number)
                pass_on(small[number], large[large.size() == 1 ? 0 : number / 4]);
            small = std::vector<Region>();  // frees the memory
        }
    }

private:
    static void pass_on(const Region& from, Region& to) {
        if (to.last == Triangulation::kNone) to.last = from.last;
        to.stack.insert(to.stack.end(), from.edges.begin(), from.edges.end());
        to.sites.insert(to.sites.end(), from.sites.begin(), from.sites.end());
        to.flips += from.flips;
    }

    int first_level_ = 0;
    std::vector<std::vector<Region>> levels_;  ///< [levels][blocks], from the first level to the last
};

}  // namespace ccdt
