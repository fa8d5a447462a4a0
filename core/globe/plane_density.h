#pragma once

#include <cstddef>
#include <stop_token>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/globe/region.h"
#include "core/result.h"

namespace ccdt {

/// Density in the plane of a chart.
struct PlaneDensity {
    Density density;   ///< stretched over the part's bounding box
    double total = 0;  ///< integral over the part: of the ground, in square metres, times what the ground wants
};

/// Makes the density in the plane that is even on the ground, or as the ground wants it.
///
/// @param degrees  the region, in one turn
/// @param density  stretched over the region's bounding box
/// @param sites    that there will be: more of them make it finer
/// Errors: Unusable if it is zero all over; Stopped.
Result<PlaneDensity> plane_density(const ChartedPart& part, const Domain& degrees, const Density& density,
                                   std::size_t sites, const std::stop_token& stop = {});

}  // namespace ccdt
