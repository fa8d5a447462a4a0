// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/ring_input.h"
#include "core/geometry/unit_frame.h"

namespace ccdt {

/// A fault of a polygon that has been repaired.
struct Repair {
    std::string field;   ///< JSON Pointer relative to the polygon, /part/ring/vertex; shorter if the vertex or the ring
                         ///< is not known
    std::string detail;  ///< readable text: the rings, the fault, and its position in the caller's coordinates
};

/// Faults of one ring or of a pair of rings, in ascending order of severity.
enum class Fault { Touches, IsCut, Overlaps, LiesOutside, RunsAlong, Crosses, HasNoArea };

/// Collects faults of rings and describes them. For each pair of rings, only the most severe fault is kept.
class Faults {
public:
    static constexpr std::size_t kNoCorner = ~std::size_t{0};

    /// @param ring      index of the ring
    /// @param other     index of the other ring; equal to `ring` if there is none
    /// @param corner    corner of `ring` near the fault; kNoCorner if there is none
    /// @param position  position of the fault, in the unit frame
    void add(Fault fault, std::size_t ring, std::size_t other, std::size_t corner, Point position);

    bool empty() const { return found_.empty(); }

    /// Whether the ring has any fault.
    bool concerns(std::size_t ring) const { return concerned_.contains(ring); }

    /// Describes the faults in the order of the rings: the first hundred, then one entry with the number of further
    /// faults. If a ring has no area, no other fault of the ring is reported.
    std::vector<Repair> describe(std::span<const RingInput> rings, const UnitFrame& frame) const;

private:
    struct Found {
        Fault fault = Fault::Touches;
        std::size_t corner = kNoCorner;
        Point position;
        std::size_t positions = 0;  ///< number of positions with this fault
    };
    std::map<std::pair<std::size_t, std::size_t>, Found> found_;  ///< keyed by the ring and the other ring
    std::set<std::size_t> concerned_;
};

}  // namespace ccdt
