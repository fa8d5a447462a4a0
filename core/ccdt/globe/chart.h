// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/geometry/point.h"

namespace ccdt {

/// A unit vector: a point on the sphere onto which the ellipsoid is mapped.
struct Direction {
    double x = 0;
    double y = 0;
    double z = 0;

    friend Direction operator+(Direction a, Direction b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Direction operator*(double s, Direction a) { return {s * a.x, s * a.y, s * a.z}; }
    Direction operator-() const { return {-x, -y, -z}; }
};

inline double dot(Direction a, Direction b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

Direction normalised(Direction v);

/// Maps the WGS 84 ellipsoid conformally onto the unit sphere: latitudes become conformal latitudes.
///
/// @param position  longitude, plus any number of turns, and latitude in [-90, 90]; degrees. Longitudes that differ by
///               whole turns give identical bytes, and so do all longitudes of a pole.
///
/// Source: Karney, Transverse Mercator with an accuracy of a few nanometers, J. Geodesy 85 (2011), eqs. 7 to 9.
Direction direction_of(Point position);

/// Computes the inverse of direction_of(), by Newton's method, to double precision. The longitude is in [-180, 180].
/// Source: Karney 2011, as for direction_of(), eqs. 19 to 21.
Point position_of(Direction direction);

/// A conformal map of the ellipsoid, except for one point, onto a plane. It maps the ellipsoid to the sphere, and the
/// sphere to the plane by stereographic projection from the point opposite the centre. The centre maps to the origin,
/// where the unit of the plane is the sphere's radius. Angles equal those on the ground; `ground()` gives the scale of
/// areas.
///
/// Source: Snyder, Map Projections: A Working Manual, USGS 1395 (1987), pp. 157 to 163. Equal to PROJ's `+proj=stere
/// +ellps=WGS84` up to unit and rotation. Why not PROJ: it has no closed form of the scale, and its inverse is accurate
/// to 1e-10 radians only. It would also add curl, GnuTLS, LDAP and Kerberos to a process that serves unknown clients.
/// Tests compare with PROJ.
class Chart {
public:
    explicit Chart(Direction centre);

    Point to_plane(Direction direction) const;
    Direction to_direction(Point plane) const;

    /// Returns the ground area in square metres per squared unit of the plane, at a point of the plane.
    double ground(Point plane) const;

    Direction centre() const { return centre_; }

private:
    Direction centre_, right_, up_;
};

}  // namespace ccdt
