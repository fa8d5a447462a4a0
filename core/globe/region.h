#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/polygon.h"
#include "core/globe/chart.h"
#include "core/result.h"

namespace ccdt {

/// Rewrites polygons on the globe so that in degrees, too, each ring is closed and runs on without a jump: an edge that
/// spans more than 180 and less than 360 degrees of longitude is taken to go the other way round; a ring that goes
/// around a pole gets an edge along it, that of the pole which most of it is nearer to; and holes come to their outer
/// ring's turn of the globe. In a ring with such edges one of 360 degrees is none. Rings keep their corners' indices.
///
/// @param parts  positions in longitude and latitude, degrees
/// Errors (Unusable): a longitude beyond 540, or a latitude beyond 90, to either side, or no number; `field` is that of
/// Domain::create.
Result<std::vector<PolygonPart>> unrolled(std::vector<PolygonPart> parts);

/// Brings a region whose longitudes span more than 360 degrees into [-180, 180]: what lies beyond is cut off and comes
/// in again on the other side. Other regions stay as they are. Errors: those of Domain::enclosed_by.
Result<Domain> in_one_turn(const Domain& degrees, const std::stop_token& stop = {});

/// The least distance that is kept from a border, if any is: less is hardly told from the rounding of degrees. Metres.
inline constexpr double kLeastBuffer = 1e-5;

/// A part of a region of the globe, on a chart of its own.
struct ChartedPart {
    Chart chart;
    Domain domain;            ///< in the chart's plane
    double seam = 0;          ///< radius of the circle around the origin along which the region was cut; 0: it was not
    double error = 0;         ///< metres on the ground by which edges may be off, if that is much against the buffer
    double indifference = 0;  ///< distance in the plane that sites with a buffer do not show
};

/// Lays a region of the globe onto charts: on one if a cap of some degrees is free of it, with the centre opposite the
/// largest such cap, so that scales vary as little as they can. What covers the globe otherwise is cut along a circle:
/// the second part is what lies inside.
///
/// @param degrees  the region in longitude and latitude, in one turn; its edges are straight there (RFC 7946, section
///                 3.1.1). Where it reaches around the globe, west and east meet, and what they share is no border
/// @param sites    that it will have: edges are bent in the plane as far as may matter to these, to a thousandth of
///                 their pitch
/// @param buffer   distance in metres that these will keep from the border; 0 if there is none. Edges are bent to a
///                 4,000th of it, or as closely as 10,000 pieces allow (see ChartedPart::error). None is as near to a
///                 cut
/// Errors (Unusable): extents below a centimetre; what is strewn so closely over all of the globe that no cap is free
/// of its border; Stopped. Same input, same bytes.
Result<std::vector<ChartedPart>> chart_region(const Domain& degrees, std::size_t sites, double buffer = 0,
                                              const std::stop_token& stop = {});

/// Distance that so many sites have in a region, in one turn of the globe: on the sphere of a chart.
double ground_pitch(const Domain& degrees, std::size_t sites);

/// Lays another region, in one turn, onto a chart, which must reach it. Edges are bent as chart_region() has it.
/// @param pitch  of the sites, on the chart's sphere
Result<Domain> lay_on_chart(const Chart& chart, const Domain& degrees, double pitch, const std::stop_token& stop = {});

}  // namespace ccdt
