// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/faults.h"
#include "core/geometry/polygon.h"
#include "core/geometry/ring_input.h"
#include "core/geometry/unit_frame.h"

namespace ccdt {

/// Returns the limit on the pieces into which crossings may cut segments. It permits rings with very many crossings,
/// but bounds the memory.
/// @param more  additional pieces per corner
constexpr std::size_t max_pieces(std::size_t corners, std::size_t more = 0) {
    return corners / 4 + 200'000 + more * corners;
}

/// The border of the area that rings enclose, and the faults of the rings.
struct Enclosed {
    /// The inside lies on the left. Rings touch only at corners. Where several separate sectors of the inside meet at
    /// one point, each sector has its own corner there.
    std::vector<Ring> rings;
    std::vector<Repair> repairs;
};

/// Computes the area that rings enclose. By the even-odd rule, a ring encloses its inside. A part is its outer ring
/// minus its holes. The area is the union of all parts.
///
/// @param rings  in the unit frame; outer rings counter-clockwise, holes clockwise
/// @param frame  the unit frame of the corners
/// @param stop   polled regularly; a stop gives the error Stopped
///
/// Simple rings that meet nowhere are returned unchanged. Rings that are valid by OGC Simple Features need no repair;
/// such rings and parts may touch at points. All other rings are cut where they meet, see arrange(). Cutting moves
/// edges by rounding errors near crossings and changes nothing else. A sliver of the inside, or a gap between parts, is
/// dropped if it is no thicker than a rounding error.
///
/// Errors (Unusable): crossings that create more pieces than max_pieces() allows.
///
/// The result equals that of GEOS' MakeValid with the structure method. Why not GEOS: it works in the caller's
/// coordinates, and conversion of its result to the unit frame could make the result invalid again. The overlays of
/// GEOS snap vertices together where rounding interferes. Interrupting GEOS affects the whole process. Why not CGAL's
/// Constrained_triangulation_plus_2: it keeps a list of vertices, some hundred bytes, for each segment, although few
/// segments are cut.
Result<Enclosed> enclosed_area(const std::vector<RingInput>& rings, const UnitFrame& frame,
                               const std::stop_token& stop = {});

/// Computes the area that rings together enclose by the even-odd rule. Like enclosed_area(), but reports no faults.
Result<std::vector<Ring>> enclosed_together(const std::vector<Ring>& rings, const UnitFrame& frame,
                                            const std::stop_token& stop = {});

/// Subtracts areas from an area and returns the border of the difference. Like enclosed_area(), but reports no faults.
/// @param area, others  in the unit frame, within the unit square
/// @param resolution    parts of about this thickness or less are dropped
/// @param more          additional pieces per corner that crossings may create, see max_pieces()
Result<Area> difference(const Area& area, std::span<const Area> others, double resolution,
                        const std::stop_token& stop = {}, std::size_t more = 0);

/// Returns the border of the union of several areas.
/// @param resolution  parts of about this thickness or less are dropped
/// @param more        additional pieces per corner that crossings may create, see max_pieces()
Result<Area> united(std::span<const Area> areas, double resolution, const std::stop_token& stop = {},
                    std::size_t more = 0);

}  // namespace ccdt
