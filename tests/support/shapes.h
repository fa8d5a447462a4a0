// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt::test {

using Parts = std::vector<PolygonPart>;

Ring box(double x, double y, double width, double height);

/// Corners of a regular polygon, counter-clockwise; every second one at the inner radius.
Ring star(Point centre, double outer, double inner, int corners);
Ring circle(Point centre, double radius, int corners);

Ring l_shape();
Ring u_shape();

/// Unit square with count x count square holes.
PolygonPart sieve(int count);

/// Coordinates of a GeoJSON Polygon or MultiPolygon among the tests' data.
Parts read_geojson(const std::string& name);

Parts scaled(Parts parts, double factor);
Parts moved(Parts parts, Point by);

/// Strictly inside a part, by exact predicates: inside its outer ring and no hole, by the even-odd rule, which is as
/// good for rings that cross.
bool contains(const Parts& parts, Point p);

/// Distance to the nearest edge.
double distance_to_border(const Parts& parts, Point p);

/// How many of the points lie outside or on the border.
std::size_t count_outside(const Parts& parts, const std::vector<Point>& points);
std::size_t count_distinct(const std::vector<Point>& points);

}  // namespace ccdt::test
