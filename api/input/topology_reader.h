#pragma once

#include <optional>
#include <string>

#include "api/input/option_reader.h"
#include "api/input/polygon_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Tells whether a value is a TopoJSON document.
bool is_topology(JsonValue value);

/// Finds the object of a TopoJSON document that is asked for.
/// @param name  none: the only one
/// Errors: Malformed if there is none of that name, or several to choose from; the message names them.
Result<Input> find_object(const Input& topology, const std::optional<std::string>& name);

/// Reads an object of a TopoJSON document: a Polygon, a MultiPolygon, or a GeometryCollection of such, each geometry
/// of which is a feature. Arcs may be quantized. Geometries whose type is null have no polygons.
///
/// @param object  that find_object() has found
/// Errors: Malformed, with a JSON Pointer to what is wrong; Unusable if it is empty; LimitExceeded for more than
/// PolygonInput::kMaxCorners. Source: the TopoJSON format specification, version 1.0.
Result<PolygonInput> read_topology(const Input& topology, const Input& object);

}  // namespace ccdt::api
