// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <stop_token>

#include "core/base/result.h"
#include "core/ccdt/globe/region.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"

namespace ccdt {

/// A density in the plane of a chart.
struct PlaneDensity {
    Density density;   ///< stretched over the part's bounding box
    double total = 0;  ///< integral of the wanted density over the part, in square metres of ground
};

/// Computes the density in the plane for a wanted density on the ground, which may be uniform.
///
/// @param degrees  the region in longitude and latitude, as returned by in_one_turn()
/// @param density  stretched over the region's bounding box
/// @param sites    number of sites to be distributed; more sites give a finer grid
///
/// Errors: Unusable if the density is zero everywhere; Stopped.
Result<PlaneDensity> plane_density(const ChartedPart& part, const Domain& degrees, const Density& density,
                                   std::size_t sites, const std::stop_token& stop = {});

}  // namespace ccdt
