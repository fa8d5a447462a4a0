// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/repair.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include "core/geometry/cover.h"
#include "core/geometry/delaunay.h"

namespace ccdt {

namespace {

void append_chain(const Ring& corners, std::uint32_t group, Chains& chains) {
    const auto first = static_cast<std::uint32_t>(chains.points.size());
    const auto size = static_cast<std::uint32_t>(corners.size());
    for (std::uint32_t i = 0; i < size; ++i) {
        chains.points.push_back(corners[i]);
        chains.next.push_back(first + (i + 1) % size);
        chains.group.push_back(group);
    }
}

tl::expected<Arrangement, TooManyCrossings> arrange(const Chains& chains, double resolution,
                                                    const std::stop_token& stop, std::size_t more = 0) {
    return arrange(chains, resolution, max_pieces(chains.points.size(), more), stop);
}

tl::unexpected<Error> stopped() {
    return failure(ErrorCode::Stopped, "stopped before the polygon was validated");
}

/// Collects groups of chains and traces the border of the area that they cover.
class Groups {
public:
    void append(const Area& rings, Cover::Kind kind) {
        for (const Ring& ring : rings) append_chain(ring, static_cast<std::uint32_t>(kinds_.size()), chains_);
        kinds_.push_back(kind);
    }

    /// Returns the border of the area that the groups cover.
    Result<Area> trace(double resolution, const std::stop_token& stop, std::size_t more) {
        chains_.groups = static_cast<std::uint32_t>(kinds_.size());
        const auto map = arrange(chains_, resolution, stop, more);
        if (!map) return failure(ErrorCode::Unusable, "the polygon crosses itself too often to be repaired");
        if (stop.stop_requested()) return stopped();
        const Cover cover(chains_, *map, kinds_, resolution, stop);
        if (stop.stop_requested()) return stopped();
        return cover.trace();
    }

private:
    Chains chains_;
    std::vector<Cover::Kind> kinds_;
};

}  // namespace

Result<Enclosed> enclosed_area(const std::vector<RingInput>& rings, const UnitFrame& frame,
                               const std::stop_token& stop) {
    Chains chains;
    std::vector<Cover::Kind> kinds;
    for (const RingInput& ring : rings) {
        append_chain(ring.corners, static_cast<std::uint32_t>(kinds.size()), chains);
        kinds.push_back({ring.part, ring.is_hole()});
    }
    chains.groups = static_cast<std::uint32_t>(kinds.size());
    const auto map = arrange(chains, frame.resolution(), stop);
    if (!map) {
        const std::uint32_t group = chains.group[map.error().segment];
        const auto first = std::ranges::find(chains.group, group) - chains.group.begin();
        Faults faults;
        faults.add(Fault::Crosses, group, group, map.error().segment - static_cast<std::size_t>(first),
                   map.error().position);
        const Repair fault = faults.describe(rings, frame).front();
        return failure(ErrorCode::Unusable, fault.detail + " and too often to be repaired", fault.field);
    }
    if (stop.stop_requested()) return stopped();
    const Cover cover(chains, *map, kinds, frame.resolution(), stop);
    if (stop.stop_requested()) return stopped();
    Enclosed result{{}, cover.faults().describe(rings, frame)};
    if (result.repairs.empty() && !cover.has_contacts()) {
        for (const RingInput& ring : rings) result.rings.push_back(ring.corners);
    } else {
        result.rings = cover.trace();
    }
    return result;
}

Result<std::vector<Ring>> enclosed_together(const std::vector<Ring>& rings, const UnitFrame& frame,
                                            const std::stop_token& stop) {
    return difference(rings, {}, frame.resolution(), stop);
}

Result<Area> difference(const Area& area, std::span<const Area> others, double resolution, const std::stop_token& stop,
                        std::size_t more) {
    // The area is the outer group of one part, and each subtracted area is a hole of it. Groups may have several rings.
    Groups groups;
    groups.append(area, {0, false});
    for (const Area& other : others) groups.append(other, {0, true});
    return groups.trace(resolution, stop, more);
}

Result<Area> united(std::span<const Area> areas, double resolution, const std::stop_token& stop, std::size_t more) {
    Groups groups;
    for (std::size_t part = 0; part < areas.size(); ++part) groups.append(areas[part], {part, false});
    return groups.trace(resolution, stop, more);
}

}  // namespace ccdt
