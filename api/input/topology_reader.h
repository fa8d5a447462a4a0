// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "api/input/option_reader.h"
#include "api/input/polygon_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Returns whether a value is a TopoJSON document.
bool is_topology(JsonValue value);

/// Finds an object of a TopoJSON document by name.
/// @param name  none: the only object
/// Errors: Malformed if no object has that name, or if there are several and none is named; the message lists their
/// names.
Result<Input> find_object(const Input& topology, const std::optional<std::string>& name);

/// Reads an object of a TopoJSON document: a Polygon, a MultiPolygon, or a GeometryCollection of such, each geometry of
/// which is a feature. Arcs may be quantized. Geometries whose type is null have no polygons.
///
/// @param object  result of find_object()
/// Errors: Malformed, with a JSON Pointer to the faulty value; Unusable if there is no polygon; LimitExceeded for more
/// than PolygonInput::kMaxCorners. Source: the TopoJSON format specification, version 1.0.
Result<PolygonInput> read_topology(const Input& topology, const Input& object);

}  // namespace ccdt::api
