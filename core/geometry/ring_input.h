#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/polygon.h"
#include "core/result.h"

namespace ccdt {

/// A ring on its way into a domain, with the way back to what the caller wrote.
struct RingInput {
    std::size_t part = 0;
    std::size_t ring = 0;             ///< 0 is the outer one
    Ring corners;                     ///< repeated ones dropped; fewer than three enclose nothing
    std::vector<std::size_t> source;  ///< the caller's index of each corner

    bool is_hole() const { return ring > 0; }

    /// Drops corners that are equal to the one before.
    void drop_repeated();

    /// For people: "hole 2 of part 1".
    std::string name() const;

    /// JSON Pointer below the polygon, to the ring or to one of its corners.
    std::string pointer() const;
    std::string pointer(std::size_t corner) const;
};

/// Rings of all parts in turn, outer ones first.
/// Errors (Unusable): no part; a coordinate that is not finite.
Result<std::vector<RingInput>> read_rings(const std::vector<PolygonPart>& parts);

}  // namespace ccdt
