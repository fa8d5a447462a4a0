// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/geometry/faults.h"
#include "core/geometry/polygon.h"
#include "core/geometry/ring_input.h"
#include "core/geometry/unit_frame.h"
#include "core/result.h"

namespace ccdt {

/// Returns the limit on the pieces that crossings may create: enough for scribbles, and little enough to bound the
/// memory.
/// @param more  additional pieces per corner
constexpr std::size_t most_pieces(std::size_t corners, std::size_t more = 0) {
    return corners / 4 + 200'000 + more * corners;
}

/// The border of the area that rings enclose, and the faults of the rings.
struct Enclosed {
    /// The inside lies on the left. Rings meet at corners at most. If the inside has several fans of triangles at one
    /// place, each fan has its own corner there.
    std::vector<Ring> rings;
    std::vector<Repair> repairs;
};

/// Computes the area that rings enclose. A ring encloses its inside by the even-odd rule, a part is its outer ring
/// minus its holes, and the area is the union of all parts.
///
/// @param rings  in the unit frame; outer rings counter-clockwise, holes clockwise
/// @param frame  the unit frame of the corners
/// @param stop   polled regularly; a stop gives the error Stopped
///
/// Simple rings that meet nowhere are returned unchanged. Rings that are valid by OGC Simple Features need no repair;
/// such rings and parts may touch at points. All others are cut where they meet, see arrange(). That moves edges by
/// rounding errors near crossings and changes nothing else. Slivers inside, and gaps between parts, that are no thicker
/// than such an error are indistinguishable from rounding and are dropped.
///
/// Errors (Unusable): crossings that create more than most_pieces().
///
/// The result equals that of GEOS' MakeValid with the structure method. Why not GEOS itself: it works in the caller's
/// coordinates, so converting the result to the unit frame would break it again; its overlays snap vertices together
/// where rounding interferes; and it can be interrupted only for the whole process. Why not CGAL's
/// Constrained_triangulation_plus_2: it keeps a list of vertices, some hundred bytes, for each segment, although few
/// are cut.
Result<Enclosed> enclosed_area(const std::vector<RingInput>& rings, const UnitFrame& frame,
                               const std::stop_token& stop = {});

/// Computes the area that rings together enclose by the even-odd rule; otherwise as enclosed_area(), without a report
/// of faults.
Result<std::vector<Ring>> enclosed_together(const std::vector<Ring>& rings, const UnitFrame& frame,
                                            const std::stop_token& stop = {});

/// Subtracts areas from an area and returns the border of the rest; otherwise as enclosed_area(), without a report of
/// faults.
/// @param area, others  in the unit frame, within the unit square
/// @param resolution    parts of about this thickness or less are dropped
/// @param more          additional pieces per corner that crossings may create, see most_pieces()
Result<Area> difference(const Area& area, std::span<const Area> others, double resolution,
                        const std::stop_token& stop = {}, std::size_t more = 0);

/// Returns the border of the union of several areas.
/// @param resolution  parts of about this thickness or less are dropped
/// @param more        as in difference()
Result<Area> united(std::span<const Area> areas, double resolution, const std::stop_token& stop = {},
                    std::size_t more = 0);

}  // namespace ccdt
