#pragma once

#include "core/geometry/point.h"

namespace ccdt {

/// A vector of length 1: a place on the sphere that the ellipsoid is mapped onto.
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

/// Maps the WGS 84 ellipsoid onto a sphere of radius 1, conformally: latitudes become conformal ones.
///
/// @param place  longitude, any number of turns, and latitude, in [-90, 90]; degrees. Longitudes that differ by turns
///               give the same bytes, and so do all of a pole
/// Source: Karney, Transverse Mercator with an accuracy of a few nanometers, J. Geodesy 85 (2011), eqs. 7 to 9.
Direction direction_of(Point place);

/// The inverse, by Newton's method, to the precision of doubles; the longitude is in [-180, 180].
/// Source: as above, eqs. 19 to 21.
Point place_of(Direction direction);

/// A conformal map of the ellipsoid, but for one point, onto a plane: onto the sphere, and from there by stereographic
/// projection from the point opposite a centre, which comes to lie at the origin. Directions on the ground are those of
/// the plane, and the ground is as large as `ground()` tells. The plane's unit is the sphere's radius at the centre.
///
/// Source: Snyder, Map Projections: A Working Manual, USGS 1395 (1987), pp. 157 to 163; the same as PROJ's
/// `+proj=stere +ellps=WGS84` but for its unit and a turn. Why not PROJ: it has no closed form of the scale, its
/// inverse ends at 1e-10 radians, and it would bring curl, GnuTLS, LDAP and Kerberos into the process that computes for
/// strangers. Tests compare with it.
class Chart {
public:
    explicit Chart(Direction centre);

    Point to_plane(Direction direction) const;
    Direction to_direction(Point plane) const;

    /// Square metres of the ground to a squared unit of the plane, at a point of it.
    double ground(Point plane) const;

    Direction centre() const { return centre_; }

private:
    Direction centre_, right_, up_;
};

}  // namespace ccdt
