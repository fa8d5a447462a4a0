// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "api/sample/plane/sample_area.h"
#include "api/sample/plane/sample_request.h"
#include "core/base/result.h"
#include "core/ccdt/maps/dot_map.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/density/density.h"

namespace ccdt::api {

struct PlacedPoints {
    /// For a dot map, [classes]; for other requests, one element with all points. If the request has features, points
    /// are grouped by feature.
    std::vector<ClassDots> classes;
    std::optional<double> pitch;  ///< only on the globe: square root of the area per point, in metres
    /// Indices into SampleArea::features of the features that the buffer removes completely; only on the globe.
    std::vector<std::uint32_t> lost = {};
};

/// Distributes the points of a request, groups them by features if the request has features, and orders them.
/// Errors: those of run_sample() about the density and the options; LimitExceeded if the properties that points carry
/// take too many bytes; Stopped.
Result<PlacedPoints> place_points(const SampleRequest& request, const SampleArea& area, const Density& density,
                                  const Control& control);

}  // namespace ccdt::api
