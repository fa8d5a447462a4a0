// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "api/input/option_reader.h"
#include "core/base/result.h"
#include "core/geometry/point.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

/// Reads points: a list of positions, or GeoJSON (RFC 7946). GeoJSON may be a Point, a MultiPoint, a Feature with one
/// of these, or a GeometryCollection or FeatureCollection of them. Ignores ordinates after the second, and features of
/// a collection if their geometry is null. The result may be empty.
/// Errors: Malformed, with a JSON Pointer to the faulty value; LimitExceeded for more than limits.max_sites points.
Result<std::vector<Point>> read_points(const Input& input, const Limits& limits);

/// Reads points with three coordinates: a list of positions [x, y, z], which may be text in JSON. Errors: as
/// read_points(), with the index of the faulty position after the field of the input.
Result<std::vector<Point3>> read_points3(const Input& input, const Limits& limits);

}  // namespace ccdt::api
