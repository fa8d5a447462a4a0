// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/globe/chart.h"
#include "core/geometry/domain.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// Rewrites polygons on the globe so that in degrees each ring is closed and has no jumps. An edge that spans more than
/// 180 and less than 360 degrees of longitude is replaced by the edge that takes the shorter way around the globe. A
/// ring that goes around a pole gets an edge along the pole in the hemisphere of the ring's mean latitude. Holes are
/// shifted by whole turns to their outer ring. If an edge of a ring is replaced, the ring's edges of 360 degrees count
/// as edges of zero length. Indices of corners are preserved.
///
/// @param parts  positions in longitude and latitude, degrees
///
/// Errors (Unusable): a longitude outside [-540, 540], a latitude outside [-90, 90], NaN; `field` as in Domain::create.
Result<std::vector<PolygonPart>> unrolled(std::vector<PolygonPart> parts);

/// Wraps a region whose longitudes span more than 360 degrees into [-180, 180]: pieces outside this range are cut off
/// and shifted by whole turns. Other regions are returned unchanged. Errors: those of Domain::enclosed_by.
Result<Domain> in_one_turn(const Domain& degrees, const std::stop_token& stop = {});

/// Least positive distance from a border, in metres. Smaller distances are close to the rounding errors of degrees.
inline constexpr double kMinBuffer = 1e-5;

/// A part of a region of the globe, on its own chart.
struct ChartedPart {
    Chart chart;
    Domain domain;  ///< in the chart's plane
    /// Radius of the circle around the origin along which the region was cut; 0 if it was not cut.
    double seam = 0;
    /// Deviation of the domain's edges, in metres on the ground; 0 if negligible relative to the buffer.
    double error = 0;
    double indifference = 0;  ///< parameter of inset(): distance in the plane that is too small to matter
};

/// Projects a region of the globe onto charts. If a cap with a radius of 5 degrees lies outside the region, one chart
/// suffices. The chart's centre is in the middle of a small region, and otherwise opposite the largest such cap, which
/// minimises the variation of scale. Any other region is cut along a circle, and the second part is the inside of the
/// circle.
///
/// @param degrees  the region in longitude and latitude, as returned by in_one_turn(); its edges are straight lines
///                 there (RFC 7946, section 3.1.1). If the region spans the whole globe, its west and east sides are
///                 joined; pieces that both sides have in common do not count as border.
/// @param sites    number of sites to be distributed; edges are approximated to a thousandth of their pitch
/// @param buffer   distance in metres that sites will keep from the border; 0 if none. Edges are approximated to a
///                 4,000th of this distance, or as closely as 10,000 pieces allow (see ChartedPart::error). The circle
///                 of a cut keeps more than this distance from the border.
///
/// Errors: Unusable if the extent is below a centimetre, or if the region is scattered so densely over the globe that
/// its border leaves no cap free; Stopped. Deterministic.
Result<std::vector<ChartedPart>> chart_region(const Domain& degrees, std::size_t sites, double buffer = 0,
                                              const std::stop_token& stop = {});

/// Returns the mean spacing of sites in a region, in radians on the sphere. `degrees` is a result of in_one_turn().
double ground_pitch(const Domain& degrees, std::size_t sites);

/// Projects a result of in_one_turn() onto a chart that covers it. Approximates edges as chart_region() does.
/// @param pitch  spacing of the sites, in radians on the sphere
Result<Domain> lay_on_chart(const Chart& chart, const Domain& degrees, double pitch, const std::stop_token& stop = {});

}  // namespace ccdt
