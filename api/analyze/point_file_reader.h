// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "core/base/result.h"
#include "core/geometry/point.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

/// Reads the points of a file, in a format in which this project writes points. The first bytes determine the format:
///
/// | format | points |
/// |---|---|
/// | NPY | the first two columns of an array of numbers, with at least two columns |
/// | JSON | a list of positions, the member `points` of an object, or GeoJSON as in read_points(), also a sequence of
/// texts | | CSV | the columns `x` and `y`, which the first line names, in any position | | PLY | the vertices, which
/// must be the first element; ASCII or little-endian binary |
///
/// Fields of CSV may be quoted (RFC 4180), and lines may end with or without a carriage return. A byte order mark of
/// UTF-8 at the start is ignored. Errors: Malformed for any other content; the message names the line of CSV, the row
/// of NPY, the vertex of PLY, or the JSON Pointer; LimitExceeded for more than limits.max_sites points. Error::field is
/// empty.
Result<std::vector<Point>> read_point_file(std::string_view file, const Limits& limits);

/// Reads the points of a file with three coordinates. The formats and errors are those of read_point_file(), with a
/// third coordinate: the third column of an array, the column `z`, or the third number of a position. JSON must be a
/// list of positions, or the member `points` of an object; GeoJSON is not accepted.
Result<std::vector<Point3>> read_point_file3(std::string_view file, const Limits& limits);

/// Whether a file holds points with three coordinates by its format: a PLY, or a CSV with the column `z`. An NPY or
/// JSON may hold either.
bool is_point_file3(std::string_view file);

}  // namespace ccdt::api
