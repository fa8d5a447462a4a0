// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Divides the vertices of a mesh into groups that can be moved in parallel, and lists the one-ring of each vertex as
/// Relaxation reads it. A group consists of sites whose neighbours all lie in the same block of the mesh, so that the
/// groups of a level never touch each other; the levels follow one another, and the vertices of the border come last.
class MoveGroups {
public:
    /// Records of sites of one kind, for the fast path, which uses vector instructions. A record holds the site and its
    /// neighbours counter-clockwise, with the first neighbour repeated to fill 2 * pairs + 1 entries. Unless the kind
    /// is plain, the record also holds the 2 * pairs triangles between these neighbours.
    using Batch = std::vector<std::uint32_t>;

    /// Records of sites that are moved at once, one for each lane.
    template <class Lanes>
    using Records = std::array<const std::uint32_t*, Lanes::kCount>;

    // Kinds of sites, by the number of pairs of neighbours and by whether all triangles have the common goal (plain).
    static constexpr std::size_t kMinPairs = 2, kMaxPairs = 4;
    static constexpr std::uint8_t kKinds = 2 * (kMaxPairs - kMinPairs + 1);
    static constexpr std::uint8_t kFanKind = kKinds;  ///< general path: many neighbours, or at the seam of a torus
    static constexpr std::uint8_t kind_of(bool plain, std::size_t pairs) {
        return static_cast<std::uint8_t>(2 * (pairs - kMinPairs) + (plain ? 1 : 0));
    }
    static constexpr std::size_t stride(std::uint8_t kind) {
        const std::size_t pairs = kind / 2 + kMinPairs;
        return 2 + 2 * pairs + (kind % 2 == 1 ? 0 : 2 * pairs);
    }

    /// A vertex and its one-ring, for the general path, which moves one vertex at a time: the neighbours
    /// counter-clockwise, and the triangle between each neighbour and the next one. The one-ring of a border vertex
    /// ends with a neighbour that has no triangle after it.
    struct Fan {
        std::uint32_t vertex;
        std::uint32_t first;  ///< index of the first entry of the one-ring in the lists of Fans
        std::uint32_t neighbours;
        std::uint32_t triangles;  ///< equal to `neighbours`, or one less on the border
    };

    struct Fans {
        std::vector<Fan> all;
        std::vector<std::uint32_t> vertices;  ///< concatenated one-rings
        std::vector<Point> lifts;
        std::vector<std::uint32_t> triangles;

        void clear();
    };

    using Batches = std::array<Batch, kKinds>;

    /// Sites that one task moves in sequence. While it does, no other task moves these sites or their neighbours.
    struct Group {
        const std::uint32_t* records = nullptr;          ///< records of all batches, concatenated
        std::array<std::uint32_t, kKinds + 1> begins{};  ///< start of each batch in `records`
        std::vector<std::uint32_t> own;                  ///< the records, if the group stores them itself
        Fans fans;
        /// All sites of the group. Empty at level 0, where the group consists of the block's sites whose level is 0.
        std::vector<std::uint32_t> sites;
        std::vector<std::uint32_t> others;  ///< sites of the block that belong to the group of a larger block

        std::span<const std::uint32_t> batch(std::uint8_t kind) const {
            return {records + begins[kind], begins[kind + std::size_t{1}] - begins[kind]};
        }
        void clear();
        void store(const Batches& batches, std::span<std::uint32_t> memory);
    };

    /// @param mesh     must outlive this object
    /// @param fixed    [vertices - sites] for the border's vertices: whether the vertex never moves
    /// @param uniform  whether all triangles between three sites have the same goal
    MoveGroups(const Triangulation& mesh, std::vector<bool> fixed, bool uniform)
        : mesh_(mesh), fixed_(std::move(fixed)), uniform_(uniform) {}

    /// Lists the sites of each group, and their one-rings. O(vertices).
    /// @param stop  polled regularly; after a stop the groups must not be used
    void list(const std::stop_token& stop);

    /// Lists the sites of each group without their one-rings, which takes less memory. O(vertices).
    /// @param stop  polled regularly; after a stop the groups must not be used
    void list_sites(const std::stop_token& stop);

    /// Whether list() was never called, or list_sites() was called after it.
    bool has_no_rings() const { return kinds_.empty(); }
    std::size_t levels() const { return groups_.size(); }
    std::span<const Group> level(std::size_t level) const { return groups_[level]; }
    /// The vertices of the border that move.
    const Fans& border() const { return border_; }

    /// Calls visit(site) for each site of a group.
    template <class Visit>
    void for_sites(std::size_t level, std::size_t number, Visit&& visit) const {
        for (const std::uint32_t site : groups_[level][number].sites) visit(site);
        if (level > 0) return;
        const std::uint32_t end = mesh_.blocks().begin(number + 1);
        for (std::uint32_t site = mesh_.blocks().begin(number); site < end; ++site) {
            if (levels_[site] == 0) visit(site);
        }
    }

    /// Adds a vertex and its one-ring.
    void add_fan(std::uint32_t vertex, Fans& fans) const;

private:
    void make_groups();
    void list_border();
    void list_larger_blocks(bool exact);
    std::size_t record_memory_of(std::size_t sites) const;
    void list_block(std::size_t number, bool first_time);
    void find_levels(std::size_t number, bool first_time);
    void list_larger(std::size_t level, std::size_t number, bool exact);
    std::uint8_t level_of(std::uint32_t site) const;
    bool add_site(std::uint32_t site, Batches& batches, Fans& fans, std::uint32_t first, std::uint32_t size);

    const Triangulation& mesh_;
    std::vector<bool> fixed_;
    bool uniform_;
    std::vector<std::uint8_t> kinds_;  ///< [sites] kind of each site, as long as there are records
    /// [sites] level of the smallest block that contains a site and all its free neighbours
    std::vector<std::uint8_t> levels_;
    std::vector<std::vector<Group>> groups_;  ///< [levels][blocks] groups of sites
    /// Memory for the records of all level-0 blocks. It is allocated and freed in one piece, because freed pieces of
    /// the size of a block would be too small for later allocations.
    std::vector<std::uint32_t> record_memory_;
    Fans border_;
};

}  // namespace ccdt
