// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/move_groups.h"

#include <algorithm>

namespace ccdt {

void MoveGroups::list_border() {
    border_.clear();
    const auto sites = static_cast<std::uint32_t>(mesh_.site_count());
    for (std::uint32_t v = sites; v < mesh_.vertex_count(); ++v) {
        if (!fixed_[v - sites]) add_fan(v, border_);
    }
}

void MoveGroups::make_groups() {
    const SiteBlocks& blocks = mesh_.blocks();
    groups_.resize(static_cast<std::size_t>(blocks.levels()));
    for (int level = 0; level < blocks.levels(); ++level)
        groups_[static_cast<std::size_t>(level)].resize(blocks.count(level));
}

void MoveGroups::list(const std::stop_token& stop) {
    make_groups();
    const SiteBlocks& blocks = mesh_.blocks();
    const bool first_time = kinds_.empty();
    record_memory_.resize(record_memory_of(blocks.sites()));
    kinds_.resize(blocks.sites(), kFanKind);
    levels_.resize(blocks.sites());
    mesh_.executor().run(blocks.count(0), [&](std::size_t number) {
        if (!stop.stop_requested()) list_block(number, first_time);
    });
    list_larger_blocks(false);
    list_border();
}

void MoveGroups::list_sites(const std::stop_token& stop) {
    make_groups();
    const bool first_time = levels_.empty();
    kinds_ = std::vector<std::uint8_t>();
    record_memory_ = std::vector<std::uint32_t>();
    levels_.resize(mesh_.blocks().sites());
    mesh_.executor().run(groups_[0].size(), [&](std::size_t number) {
        if (!stop.stop_requested()) find_levels(number, first_time);
    });
    list_larger_blocks(true);
    list_border();
}

/// Lists the groups of all levels above 0.
/// @param exact  as in list_larger()
void MoveGroups::list_larger_blocks(bool exact) {
    for (std::size_t level = 1; level < groups_.size(); ++level) {
        mesh_.executor().run(groups_[level].size(), [&](std::size_t number) { list_larger(level, number, exact); });
    }
}

void MoveGroups::Fans::clear() {
    all.clear();
    vertices.clear();
    lifts.clear();
    triangles.clear();
}

/// Clears everything but the records.
void MoveGroups::Group::clear() {
    fans.clear();
    sites.clear();
    others.clear();
}

/// Stores new records: in `memory` if they fit, else in the group.
void MoveGroups::Group::store(const Batches& batches, std::span<std::uint32_t> memory) {
    for (std::size_t kind = 0; kind < kKinds; ++kind)
        begins[kind + 1] = begins[kind] + static_cast<std::uint32_t>(batches[kind].size());
    std::uint32_t* to = memory.data();
    if (begins.back() > memory.size()) {
        own.resize(begins.back());
        to = own.data();
    }
    for (std::size_t kind = 0; kind < kKinds; ++kind) std::ranges::copy(batches[kind], to + begins[kind]);
    records = to;
}

/// Returns the number of 32-bit words reserved for the records of `sites` sites. The mean number of neighbours is 6,
/// and the last pair of a record may be half empty. A block that needs more stores its records itself.
std::size_t MoveGroups::record_memory_of(std::size_t sites) const {
    constexpr double kSpare = 1.06;
    const double neighbours = 6.5, plain = 2 + neighbours, general = plain + neighbours;
    return static_cast<std::size_t>(kSpare * (uniform_ ? plain : general) * static_cast<double>(sites));
}

/// Lists the sites of a block whose free neighbours are all in the block, and collects the other sites in
/// Group::others. Records of sites with unchanged neighbours, which are most, are copied from the old batches.
void MoveGroups::list_block(std::size_t number, bool first_time) {
    const SiteBlocks& blocks = mesh_.blocks();
    const std::uint32_t begin = blocks.begin(number), end = blocks.begin(number + 1);
    Group& group = groups_[0][number];
    Batches batches;
    for (std::uint8_t kind = 0; kind < kKinds; ++kind) {
        const std::size_t size = group.batch(kind).size();
        batches[kind].reserve(size + size / 16);  // most sites keep their kind
    }
    group.clear();
    std::array<std::size_t, kKinds> taken{};
    for (std::uint32_t v = begin; v < end; ++v) {
        const bool kept = !first_time && !mesh_.has_changed(v);
        const std::uint8_t kind = first_time || levels_[v] > 0 ? kFanKind : kinds_[v];
        if (kind != kFanKind) {
            const std::uint32_t* const record = group.batch(kind).data() + taken[kind];
            taken[kind] += stride(kind);
            if (kept) {
                batches[kind].insert(batches[kind].end(), record, record + stride(kind));
                continue;
            }
        }
        if (kept && levels_[v] > 0) {
            group.others.push_back(v);
        } else if (add_site(v, batches, group.fans, begin, end - begin)) {
            levels_[v] = 0;
        } else {
            levels_[v] = level_of(v);
            group.others.push_back(v);
        }
    }
    group.store(
        batches,
        std::span(record_memory_).subspan(record_memory_of(begin), record_memory_of(end) - record_memory_of(begin)));
}

/// Determines the level of each site of a level-0 block (see levels_). Keeps levels that are known, if the neighbours
/// of the site are unchanged. Lists the sites above level 0, which move with a larger block.
void MoveGroups::find_levels(std::size_t number, bool first_time) {
    const SiteBlocks& blocks = mesh_.blocks();
    Group& group = groups_[0][number];
    group = {};
    for (std::uint32_t v = blocks.begin(number); v < blocks.begin(number + 1); ++v) {
        if (first_time || mesh_.has_changed(v)) levels_[v] = level_of(v);
        if (levels_[v] > 0) group.others.push_back(v);
    }
}

/// Lists the sites for which a block above level 0 is the smallest one that contains them and their free neighbours.
/// @param exact  whether to list the sites alone, without records
void MoveGroups::list_larger(std::size_t level, std::size_t number, bool exact) {
    Group& group = groups_[level][number];
    group.clear();
    Batches batches;
    const auto& smaller = groups_[level - 1];
    const std::size_t first = groups_[level].size() == 1 ? 0 : 4 * number;
    const std::size_t last = groups_[level].size() == 1 ? smaller.size() : first + 4;
    for (std::size_t block = first; block < last; ++block) {
        for (const std::uint32_t v : smaller[block].others) {
            if (levels_[v] > level) {
                group.others.push_back(v);
            } else {
                group.sites.push_back(v);
                if (!exact) add_site(v, batches, group.fans, 0, Triangulation::kNone);
            }
        }
    }
    group.store(batches, {});
}

/// Returns the level of the smallest block that contains a site and all its free neighbours.
std::uint8_t MoveGroups::level_of(std::uint32_t site) const {
    const SiteBlocks& blocks = mesh_.blocks();
    const std::uint32_t own = blocks.of(site), first = mesh_.edge_of(site);
    std::uint32_t apart = 0, h = first;
    do {
        const std::uint32_t other = mesh_.target(h);
        if (mesh_.is_free(other)) apart |= blocks.of(other) ^ own;
        h = mesh_.twin(Triangulation::previous(h));
    } while (h != first);
    return static_cast<std::uint8_t>(blocks.block(own, apart).level);
}

/// Adds a site to a batch of records or, for the general path, to the fans.
/// @param first, size  range of sites in the group
/// @returns            false, without any change, if the site has free neighbours outside the group
bool MoveGroups::add_site(std::uint32_t site, Batches& batches, Fans& fans, std::uint32_t first, std::uint32_t size) {
    constexpr std::size_t kMax = 2 * kMaxPairs;
    std::array<std::uint32_t, 2 + 2 * kMax> record;
    std::array<std::uint32_t, kMax> triangles;
    std::uint32_t* around = &record[1];
    std::size_t count = 0;
    std::uint32_t largest = 0;
    bool fits = true;
    const std::uint32_t begin = mesh_.edge_of(site);
    std::uint32_t h = begin;
    do {
        const std::uint32_t other = mesh_.target(h), triangle = Triangulation::triangle_of(h);
        if (other - first >= size && mesh_.is_free(other)) return false;
        fits = fits && count < kMax && !mesh_.crosses_seam(triangle);
        if (fits) {
            largest = std::max(largest, around[count] = other);
            triangles[count++] = triangle;
        }
        h = mesh_.twin(Triangulation::previous(h));
    } while (h != begin);
    if (!fits) {
        kinds_[site] = kFanKind;
        add_fan(site, fans);
        return true;
    }

    const std::size_t pairs = std::max((count + 1) / 2, kMinPairs);
    const bool plain = uniform_ && mesh_.is_free(largest);
    record[0] = site;
    for (std::size_t i = count; i <= 2 * pairs; ++i) around[i] = around[0];
    kinds_[site] = kind_of(plain, pairs);
    Batch& batch = batches[kinds_[site]];
    batch.insert(batch.end(), record.begin(), record.begin() + 2 + 2 * static_cast<std::ptrdiff_t>(pairs));
    if (plain) return true;
    for (std::size_t i = count; i < 2 * pairs; ++i) triangles[i] = Triangulation::kNone;
    batch.insert(batch.end(), triangles.begin(), triangles.begin() + 2 * static_cast<std::ptrdiff_t>(pairs));
    return true;
}

void MoveGroups::add_fan(std::uint32_t vertex, Fans& fans) const {
    Fan fan{vertex, static_cast<std::uint32_t>(fans.vertices.size()), 0, 0};
    const std::uint32_t first = mesh_.edge_of(vertex);
    std::uint32_t h = first;
    do {
        fans.vertices.push_back(mesh_.target(h));
        fans.lifts.push_back(mesh_.distance(mesh_.shift(h)));
        fans.triangles.push_back(Triangulation::triangle_of(h));
        ++fan.triangles;
        const std::uint32_t last = Triangulation::previous(h);
        h = mesh_.twin(last);
        if (h != Triangulation::kNone) continue;
        fans.vertices.push_back(mesh_.origin(last));
        fans.lifts.push_back({});
        fans.triangles.push_back(Triangulation::kNone);
    } while (h != Triangulation::kNone && h != first);
    fan.neighbours = static_cast<std::uint32_t>(fans.vertices.size()) - fan.first;
    fans.all.push_back(fan);
}

}  // namespace ccdt
