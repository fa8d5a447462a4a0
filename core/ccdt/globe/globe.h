// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"

namespace ccdt {

/// A method that distributes sites, with the parameters of distribute().
using Distribute = std::function<Result<Distribution>(const Domain&, const Density&, const Options&, const Control&)>;

struct GlobeDistribution {
    Distribution sites;  ///< longitude, in [-180, 180], and latitude, in degrees
    double pitch = 0;    ///< square root of the ground area per site, in metres
};

/// Distributes sites over a region of the globe. On the ground, the number of sites per square kilometre follows the
/// wanted density, and the pattern is isotropic. Computes in a conformal plane (region.h), whose scale is part of the
/// density.
///
/// @param region   in longitude and latitude, see chart_region(). Parts that overlap only after a shift by a whole turn
///                 are not united; their overlap does not belong to the region.
/// @param density  wanted density on the ground, up to a factor; stretched over the region's bounding box in degrees
/// @param options  fixed points are in degrees as well; if the region is divided into two parts, sites are divided in
///                 proportion to the ground that fixed points leave in each part
/// @param buffer   least distance of sites from the border on the ground, in metres; a cut does not count as border
/// @returns        sites strictly inside the region; iterations, trace and variation are taken from the larger part;
///                 triangles of the mesh may cross the meridian of 180 degrees
///
/// Errors: those of chart_region() and `distribute`; Unusable if the density is 0 everywhere or the buffer covers all.
///
/// Limits: a region that leaves no cap with a radius of 5 degrees free is divided into two parts, by a circle of 20
/// degrees around a point far from any border of the region. Sites keep half a row from this circle.
Result<GlobeDistribution> distribute_on_globe(const Domain& region, const Density& density, const Options& options,
                                              const Distribute& distribute, double buffer = 0,
                                              const Control& control = {});

}  // namespace ccdt
