// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/point.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// A ring being read into a domain, with references to the caller's input.
struct RingInput {
    std::size_t part = 0;
    std::size_t ring = 0;             ///< 0: the outer ring
    Ring corners;                     ///< successive corners differ; fewer than three enclose nothing
    std::vector<std::size_t> source;  ///< the caller's index of each corner

    bool is_hole() const { return ring > 0; }

    /// Drops corners equal to their predecessor.
    void drop_repeated();

    /// Returns the name of the ring for messages, such as "hole 2 of part 1".
    std::string name() const;

    /// Returns the JSON Pointer, relative to the polygon, of the ring or of one of its corners.
    std::string pointer() const;
    std::string pointer(std::size_t corner) const;
};

/// Lists the rings of all parts in order, each outer ring before its holes.
/// Errors (Unusable): no part; a coordinate that is not finite.
Result<std::vector<RingInput>> read_rings(const std::vector<PolygonPart>& parts);

}  // namespace ccdt
