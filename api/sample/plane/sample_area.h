// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "api/decode/decode.h"
#include "api/output/json_writer.h"
#include "api/run/options.h"
#include "api/sample/plane/sample_request.h"
#include "core/base/result.h"
#include "core/ccdt/maps/dot_map.h"
#include "core/geometry/domain.h"
#include "core/geometry/faults.h"
#include "core/geometry/polygon.h"

namespace ccdt::api {

/// Area in which the points of a request are placed, after exclusions have been subtracted.
struct SampleArea {
    Domain whole;                        ///< the whole area; for a dot map, the union of the features
    std::vector<MapFeature> features;    ///< features of a dot map that have an area; empty for other requests
    std::vector<std::uint32_t> numbers;  ///< [features] index of each feature in the request
    std::vector<Repair> repairs;         ///< fields are JSON Pointers in the request
    std::vector<Warning> warnings;
};

/// Builds the area of a request. In the plane, the area is also eroded by the buffer. On the globe,
/// distribute_on_globe() and distribute_dots_on_globe() erode it later.
///
/// Errors: those of run_sample() about the domain. If a feature of a dot map is invalid, the error's field is a JSON
/// Pointer to the feature.
Result<SampleArea> make_area(const SampleRequest& request, const Limits& limits, const Decode& decode,
                             const std::stop_token& stop);

/// Adds a warning for each feature of a dot map that gets no points because exclusions or the buffer remove its whole
/// area.
/// @param lost  indices into area.features
/// Errors: Unusable if the request rejects invalid polygons and such a feature should have points.
Result<void> warn_of_lost(const SampleRequest& request, std::span<const std::uint32_t> lost, SampleArea& area);

/// Returns the parts of a feature of a request. On the globe, unrolled() makes the longitudes of each part continuous.
/// Errors: those of unrolled().
Result<std::vector<PolygonPart>> parts_of(const SampleRequest& request, std::size_t feature);

}  // namespace ccdt::api
