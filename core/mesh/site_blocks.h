#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace ccdt {

/// Divides sites that are numbered along a space-filling curve into blocks of neighbours, and blocks, up to four at a
/// time, into larger ones, level by level, until one is left. What touches no site but those of one block can be done
/// at the same time as what touches those of another one of its level. A function of the number of sites alone.
class SiteBlocks {
public:
    static constexpr std::size_t kFewest = 2048;  ///< sites of a block, unless there are fewer

    /// A block of one level.
    struct Block {
        int level = 0;
        std::uint32_t number = 0;
    };

    SiteBlocks() : SiteBlocks(0) {}

    explicit SiteBlocks(std::size_t sites)
        : sites_(sites),
          bits_(static_cast<int>(std::bit_width(std::max<std::size_t>(sites / kFewest, 1))) - 1),
          share_(static_cast<double>(std::uint32_t{1} << bits_) /
                 static_cast<double>(std::max<std::size_t>(sites, 1))) {}

    std::size_t sites() const { return sites_; }
    int levels() const { return (bits_ + 1) / 2 + 1; }
    int last_level() const { return levels() - 1; }
    std::size_t count(int level) const { return std::size_t{1} << std::max(0, bits_ - 2 * level); }

    /// Number of the block of level 0 that a vertex lies in; for those that are no sites, one that there is not.
    std::uint32_t of(std::uint32_t vertex) const {
        return vertex < sites_ ? static_cast<std::uint32_t>(vertex * share_) : kOutside;
    }

    /// The smallest block with all vertices; if not all are sites, the one of the last level.
    Block around(std::initializer_list<std::uint32_t> vertices) const {
        const std::uint32_t first = of(*vertices.begin());
        std::uint32_t apart = first & kOutside;
        for (const std::uint32_t vertex : vertices) apart |= of(vertex) ^ first;
        return block(first, apart);
    }

    /// The smallest block with a block of level 0 and those whose numbers differ from it in these bits.
    Block block(std::uint32_t number, std::uint32_t apart) const {
        const int level = std::min(last_level(), (static_cast<int>(std::bit_width(apart)) + 1) / 2);
        return {level, level == last_level() ? 0 : number >> (2 * level)};
    }

    /// First site of a block of level 0; of the one after the last: the number of sites.
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
    int bits_;  ///< of the numbers of blocks of level 0
    double share_;
};

}  // namespace ccdt
