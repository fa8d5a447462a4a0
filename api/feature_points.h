// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "api/sample.h"
#include "core/dotmap/dot_map.h"
#include "core/geometry/polygon.h"
#include "core/result.h"

namespace ccdt::api {

/// Returns the parts of a feature of a request. On the globe, the parts are made continuous by unrolled().
/// Errors: those of unrolled().
Result<std::vector<PolygonPart>> parts_of(const SampleRequest& request, std::size_t feature);

/// Sorts points by the features in which they lie. Points of the same feature keep their order.
///
/// @param request  must have features
/// @param points   without a mesh, and without ranks
/// A point that lies in several features belongs to the first of these features. Errors: LimitExceeded if the
/// properties that points carry take too many bytes; Stopped.
Result<ClassDots> by_features(const SampleRequest& request, Distribution points, const std::stop_token& stop);

}  // namespace ccdt::api
