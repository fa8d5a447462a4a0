// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace ccdt {

/// Divides sites that are numbered along a space-filling curve into blocks of neighbours. On each further level, up to
/// four blocks are joined into a larger block, until a single block remains. Operations that touch only the sites of
/// one block can run in parallel with operations on other blocks of the same level. Blocks depend on the number of
/// sites alone.
class SiteBlocks {
public:
    /// Least number of sites of a block, unless there is only one block.
    static constexpr std::size_t kMinSites = 2048;

    /// A block, given by its level and its number on this level.
    struct Block {
        int level = 0;
        std::uint32_t number = 0;
    };

    SiteBlocks() : SiteBlocks(0) {}

    explicit SiteBlocks(std::size_t sites)
        : sites_(sites),
          bits_(static_cast<int>(std::bit_width(std::max<std::size_t>(sites / kMinSites, 1))) - 1),
          share_(static_cast<double>(std::uint32_t{1} << bits_) /
                 static_cast<double>(std::max<std::size_t>(sites, 1))) {}

    std::size_t sites() const { return sites_; }
    int levels() const { return (bits_ + 1) / 2 + 1; }
    int last_level() const { return levels() - 1; }
    std::size_t count(int level) const { return std::size_t{1} << std::max(0, bits_ - 2 * level); }

    /// Returns the number of the level-0 block of a vertex. A vertex that is not a site gets a number that no block
    /// has.
    std::uint32_t of(std::uint32_t vertex) const {
        return vertex < sites_ ? static_cast<std::uint32_t>(vertex * share_) : kOutside;
    }

    /// Returns the smallest block that contains all vertices; the block of the last level if any vertex is not a site.
    Block around(std::initializer_list<std::uint32_t> vertices) const {
        const std::uint32_t first = of(*vertices.begin());
        std::uint32_t apart = first & kOutside;
        for (const std::uint32_t vertex : vertices) apart |= of(vertex) ^ first;
        return block(first, apart);
    }

    /// Returns the smallest block that contains the level-0 block `number` and all level-0 blocks whose numbers differ
    /// from `number` only in the bits of `apart`.
    Block block(std::uint32_t number, std::uint32_t apart) const {
        const int level = std::min(last_level(), (static_cast<int>(std::bit_width(apart)) + 1) / 2);
        return {level, level == last_level() ? 0 : number >> (2 * level)};
    }

    /// Returns the first site of a level-0 block. For the number after the last block, returns the number of sites.
    std::uint32_t begin(std::size_t number) const {
        auto site = static_cast<std::uint32_t>(static_cast<double>(number) / share_);
        site = std::min(site, static_cast<std::uint32_t>(sites_));
        while (site > 0 && of(site - 1) >= number) --site;
        while (site < sites_ && of(site) < number) ++site;
        return site;
    }

private:
    static constexpr std::uint32_t kOutside = std::uint32_t{1} << 31;

    std::size_t sites_;
    int bits_;  ///< bits in the numbers of level-0 blocks
    double share_;
};

}  // namespace ccdt
