// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "api/input/option_reader.h"
#include "api/input/polygon_reader.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Returns whether a value is a TopoJSON document.
bool is_topology(JsonValue value);

/// Finds an object of a TopoJSON document by name.
/// @param name  none: the document must have exactly one object
/// Errors: Malformed unless exactly one object matches; the message lists the names of the objects.
Result<Input> find_object(const Input& topology, const std::optional<std::string>& name);

/// Reads an object of a TopoJSON document: a Polygon, a MultiPolygon, or a GeometryCollection of these. The geometries
/// of a collection are features. Arcs may be quantized. Leaves out geometries like read_geometry(); the type of a null
/// geometry is null.
///
/// @param object  result of find_object()
/// Errors: Malformed, with a JSON Pointer to the faulty value; those of PolygonInput::check(); LimitExceeded for more
/// than PolygonInput::kMaxCorners corners.
/// Source: the TopoJSON format specification, version 1.0.
Result<PolygonInput> read_topology(const Input& topology, const Input& object);

}  // namespace ccdt::api
