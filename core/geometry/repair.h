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

/// Pieces that crossings of so many corners may make: four each, enough for scribbles, too little to fill the memory.
/// @param more  for each corner besides
constexpr std::size_t most_pieces(std::size_t corners, std::size_t more = 0) {
    return corners / 4 + 200'000 + more * corners;
}

/// What rings enclose: its border, and what was wrong with the rings.
struct Enclosed {
    /// The inside lies on the left. Rings meet at corners at most; where the inside has several fans in one place, each
    /// has a corner there of its own.
    std::vector<Ring> rings;
    std::vector<Repair> repairs;
};

/// Finds the area that rings enclose: of each ring what is inside by the even-odd rule, of each part the outer ring's
/// area without the holes', and all parts together.
///
/// @param rings  in the unit frame; outer ones counter-clockwise and holes clockwise
/// @param frame  that the corners were taken to it by
/// @param stop   asked now and then: Error Stopped
/// Rings that are simple and meet nowhere are returned as they are. Nothing is wrong with rings that are valid by OGC
/// Simple Features: they, and parts, may touch at points. All others are cut where they meet, as arrange() has it: that
/// moves edges by rounding errors at the places where they cross and nothing else. What is no thicker than such an
/// error is told from nothing by no sampling, and is not kept: slivers inside, and gaps between parts.
/// Errors (Unusable): crossings that make more than most_pieces().
///
/// Same as GEOS' MakeValid by the structure method, which is the better known. Why not GEOS itself: it works in the
/// caller's coordinates, so that going over to the unit frame would break again what it mended; its overlays snap
/// vertices together where rounding is in their way; and it cannot be stopped but for the whole process at once. Why
/// not CGAL's Constrained_triangulation_plus_2: it keeps a list of vertices for each segment, some hundred bytes, to
/// tell what a few cut ones became.
Result<Enclosed> enclosed_area(const std::vector<RingInput>& rings, const UnitFrame& frame,
                               const std::stop_token& stop = {});

/// The same for rings that all together enclose, by the even-odd rule, one area; what is wrong is not told.
Result<std::vector<Ring>> enclosed_together(const std::vector<Ring>& rings, const UnitFrame& frame,
                                            const std::stop_token& stop = {});

/// The border of what is in an area and in none of others; otherwise as enclosed_area(), and nothing is told.
/// @param area, others  in the unit frame, within the unit square
/// @param more          pieces that crossings may make for each corner, beyond most_pieces()
Result<Area> difference(const Area& area, std::span<const Area> others, double resolution,
                        const std::stop_token& stop = {}, std::size_t more = 0);

/// The border of what is in any of several areas.
/// @param resolution  what is no thicker than this, about, is nothing
/// @param more        as above
Result<Area> united(std::span<const Area> areas, double resolution, const std::stop_token& stop = {},
                    std::size_t more = 0);

}  // namespace ccdt
