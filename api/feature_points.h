#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "api/sample.h"
#include "core/dotmap/dot_map.h"
#include "core/geometry/polygon.h"
#include "core/result.h"

namespace ccdt::api {

/// Gives the parts of a feature of a request, unrolled if they are on the globe.
/// Errors: those of unrolled().
Result<std::vector<PolygonPart>> parts_of(const SampleRequest& request, std::size_t feature);

/// Tells the points of an area by the features that they lie in, and sorts them by these; within each their order
/// stays.
///
/// @param request  with features, whose parts are those of its polygon
/// @param points   without a mesh, and not ranked yet
/// A point in several features belongs to the first of them. Errors: LimitExceeded if what points carry takes too much;
/// Stopped.
Result<ClassDots> by_features(const SampleRequest& request, Distribution points, const std::stop_token& stop);

}  // namespace ccdt::api
