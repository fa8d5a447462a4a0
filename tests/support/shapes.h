// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt::test {

using Parts = std::vector<PolygonPart>;

Ring box(double x, double y, double width, double height);

/// Returns equally spaced corners around a centre, counter-clockwise, alternately at the outer and the inner radius.
Ring star(Point centre, double outer, double inner, int corners);

/// Returns the corners of a regular polygon, counter-clockwise.
Ring circle(Point centre, double radius, int corners);

Ring l_shape();
Ring u_shape();

/// Returns the unit square with count x count square holes.
PolygonPart sieve(int count);

/// Reads the coordinates of a GeoJSON Polygon or MultiPolygon from the test data.
/// @param name  of a file in tests/data/polygons
Parts read_geojson(const std::string& name);

Parts scaled(Parts parts, double factor);
Parts moved(Parts parts, Point by);

/// Whether a point is strictly inside a part. Uses exact predicates and the even-odd rule, so rings may cross.
bool contains(const Parts& parts, Point p);

/// Returns the distance from a point to the nearest edge.
double distance_to_border(const Parts& parts, Point p);

/// Returns the number of points that are outside or on the border.
std::size_t count_outside(const Parts& parts, const std::vector<Point>& points);

/// Returns the number of different points.
std::size_t count_distinct(const std::vector<Point>& points);

}  // namespace ccdt::test
