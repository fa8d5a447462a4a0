#pragma once

#include <functional>

#include "core/ccdt/ccdt.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt {

/// A way to distribute sites, with the parameters of distribute().
using Distribute = std::function<Result<Distribution>(const Domain&, const Density&, const Options&, const Control&)>;

struct GlobeDistribution {
    Distribution sites;  ///< in longitude, within [-180, 180], and latitude, degrees
    double pitch = 0;    ///< metres: the square root of the ground to each site
};

/// Distributes sites over a region of the globe so that as many lie in a square kilometre everywhere, and
/// neighbourhoods are round on the ground: in a conformal plane (region.h), whose scale is a part of the density.
///
/// @param region   in longitude and latitude, see chart_region(); of parts that overlap but for a turn of the globe,
///                 which are not known to be the same ground, what two of them have is left out
/// @param density  stretched over the bounding box of the region in one turn: what the ground wants, relative to other
///                 ground
/// @param options  fixed points in degrees, too: where the region has two parts, each gets what these leave of it
/// @param buffer   least distance on the ground of sites from the border, in metres; a cut is no border
/// @returns        sites strictly inside the region; iterations, trace and variation are those of the larger part. The
///                 mesh's triangles may reach across the meridian of 180 degrees
/// Errors: those of chart_region() and of `distribute`; Unusable if the density is zero all over the region, or if the
/// buffer leaves nothing of it.
/// Limits: what covers the globe, but for no cap of 5 degrees, has two parts, at whose border, a circle of 20 degrees
/// around a place far from any other border, sites keep half a row's distance as at any border.
Result<GlobeDistribution> distribute_on_globe(const Domain& region, const Density& density, const Options& options,
                                              const Distribute& distribute, double buffer = 0,
                                              const Control& control = {});

}  // namespace ccdt
