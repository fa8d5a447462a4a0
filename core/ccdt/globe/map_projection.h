// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "core/ccdt/globe/turns.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/geometry/polygon.h"

namespace ccdt {

/// Returns the area of a region on the ground, in squares of degrees of a great circle (111.195 km) on the sphere that
/// has the area of the ellipsoid.
/// @param degrees  in longitude and latitude; edges are straight lines there
double ground_area(const Domain& degrees);

/// An equal-area map of the WGS 84 ellipsoid onto a plane, for drawings: equal numbers of dots in equal areas of the
/// map are equal densities on the ground. The unit of the plane is a degree of a great circle, as for ground_area(); y
/// points north in the middle of the map.
///
/// Sources: Snyder, Map Projections: A Working Manual, USGS 1395 (1987), pp. 16 and 187 to 190; Savric, Patterson and
/// Jenny, The Equal Earth map projection, IJGIS 33 (2019). Equal to PROJ's `+proj=laea` and `+proj=eqearth` with
/// `+ellps=WGS84`, up to the unit.
class MapProjection {
public:
    /// Chooses the projection for a region, by the rule of Snyder (p. 34) that azimuthal maps suit regions up to a
    /// hemisphere. The longitudes of the region are the shortest range that contains them; it may cross the
    /// antimeridian.
    ///
    /// - Lambert's azimuthal equal-area projection, centred in the middle of the longitudes and latitudes, if they fit
    ///   on a hemisphere around it.
    /// - Otherwise the same projection, centred at a pole, if the region lies on this pole's side of the equator.
    /// - Otherwise Equal Earth, around the middle of the longitudes.
    ///
    /// @param parts  at least one with corners; results of unrolled()
    static MapProjection fitting(std::span<const PolygonPart> parts);

    /// Projects a position: longitude, plus any number of turns, and latitude in [-90, 90]; degrees.
    Point operator()(Point position) const;

    /// Projects the edge from `a` to `b`, which is straight in degrees, in pieces of at most a degree. Calls
    /// line_to(point) for the end of each piece. Where the edge leaves the map on one side, calls move_to(point) for
    /// the same position on the other side.
    template <class LineTo, class MoveTo>
    void trace_edge(Point a, Point b, const LineTo& line_to, const MoveTo& move_to) const {
        const double pieces = std::max(1.0, std::ceil(std::max(std::abs(b.x - a.x), std::abs(b.y - a.y))));
        Point from = a;
        for (double i = 1; i <= pieces; ++i) {
            const Point to = i == pieces ? b : a + i / pieces * (b - a);
            if (const double east = turn_of(to.x) - turn_of(from.x); is_world_ && east != 0) {
                const double side = longitude_ + kTurn * (std::max(turn_of(from.x), turn_of(to.x)) - 0.5);
                const double latitude = from.y + (side - from.x) / (to.x - from.x) * (to.y - from.y);
                line_to(project(east * kTurn / 2, latitude));
                move_to(project(-east * kTurn / 2, latitude));
            }
            line_to((*this)(to));
            from = to;
        }
    }

private:
    MapProjection(bool is_world, Point middle);

    /// @param east  longitude relative to the middle, in [-180, 180]
    Point project(double east, double latitude) const;

    /// Returns the number of the turn in which a longitude lies. Turns begin at the western side of the map.
    double turn_of(double longitude) const { return std::floor((longitude - longitude_) / kTurn + 0.5); }

    bool is_world_;                 ///< whether the map is Equal Earth
    double longitude_;              ///< of the middle, degrees
    double sine_ = 0, cosine_ = 1;  ///< of the authalic latitude of the middle
    double stretch_ = 1;  ///< factor of x and divisor of y that make the scale in the middle equal in all directions
};

}  // namespace ccdt
