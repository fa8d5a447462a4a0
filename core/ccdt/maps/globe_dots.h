// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/maps/dot_map.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"

namespace ccdt {

struct GlobeDots {
    std::vector<ClassDots> classes;   ///< points in longitude, within [-180, 180], and latitude, in degrees
    double pitch = 0;                 ///< square root of the ground area per dot, in metres
    std::vector<std::uint32_t> lost;  ///< features that lost their dots because the buffer covers all of their area
};

/// Distributes dots as distribute_dots() does, but evenly on the ground within each feature.
///
/// @param features  in longitude and latitude
/// @param region    union of the features, in longitude and latitude, see distribute_on_globe()
/// @param density   stretched over the bounding box of the region; relative to other places in the same feature
/// @param buffer    least distance on the ground from the border of the region, in metres
///
/// Errors: those of distribute_dots() and chart_region(); Unusable if features cover the globe, or no dots are left.
Result<GlobeDots> distribute_dots_on_globe(std::span<const MapFeature> features, const Domain& region,
                                           const Density& density, const Options& options, double buffer = 0,
                                           const Control& control = {});

}  // namespace ccdt
