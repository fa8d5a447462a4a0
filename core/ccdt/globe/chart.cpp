// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/chart.h"

#include <algorithm>
#include <cmath>

#include "core/base/elementary.h"
#include "core/ccdt/globe/ellipsoid.h"
#include "core/ccdt/globe/turns.h"

namespace ccdt {

namespace {

constexpr double kSquare = kSquaredEccentricity;
const double kEccentricity = std::sqrt(kSquare);

Direction cross(Direction a, Direction b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Returns sinh(e atanh(e x)) for the eccentricity e and |x| <= 1.
double stretch(double x) {
    const double across = kEccentricity * x;
    const double y = kEccentricity * elementary::log1p(2 * across / (1 - across)) / 2;
    return y + y * y * y * (1.0 / 6 + y * y / 120);  // the next term is below 1e-18
}

/// Returns the tangent of the conformal latitude for the tangent of a geodetic latitude.
double conformal_tangent(double tangent) {
    const double secant = std::sqrt(1 + tangent * tangent);
    const double sigma = stretch(tangent / secant);
    return tangent * std::sqrt(1 + sigma * sigma) - sigma * secant;
}

/// Returns the tangent of the geodetic latitude for the tangent of a conformal latitude.
double geodetic_tangent(double conformal) {
    constexpr int kSteps = 3;  // the initial error is 1e-5, and each step squares the error
    double tangent = conformal / (1 - kSquare);
    for (int i = 0; i < kSteps; ++i) {
        const double found = conformal_tangent(tangent);
        tangent += (conformal - found) / std::sqrt(1 + found * found) * (1 + (1 - kSquare) * tangent * tangent) /
                   ((1 - kSquare) * std::sqrt(1 + tangent * tangent));
    }
    return tangent;
}

/// Returns the tangent of the conformal latitude; finite even at a pole.
double conformal_tangent(Direction direction) {
    constexpr double kMin = 1e-16;
    return direction.z / std::max(elementary::hypot(direction.x, direction.y), kMin);
}

}  // namespace

Direction normalised(Direction v) {
    return 1 / std::sqrt(dot(v, v)) * v;
}

Direction direction_of(Point position) {
    if (std::abs(position.y) >= 90) return {0, 0, std::copysign(1.0, position.y)};
    double longitude = std::remainder(position.x, 360);
    if (longitude == 180) longitude = -180;
    const double tangent = conformal_tangent(elementary::tan(position.y * kDegree));
    const double cosine = 1 / std::sqrt(1 + tangent * tangent);
    return {cosine * elementary::cos(longitude * kDegree), cosine * elementary::sin(longitude * kDegree),
            tangent * cosine};
}

Point position_of(Direction direction) {
    const double latitude = elementary::atan(geodetic_tangent(conformal_tangent(direction))) / kDegree;
    return {elementary::atan2(direction.y, direction.x) / kDegree, latitude};
}

Chart::Chart(Direction centre) : centre_(centre) {
    constexpr double kNearPole = 0.9999;
    const Direction axis = std::abs(centre.z) < kNearPole ? Direction{0, 0, 1} : Direction{0, 1, 0};
    right_ = normalised(cross(axis, centre));
    up_ = cross(centre, right_);
}

Point Chart::to_plane(Direction direction) const {
    constexpr double kMin = 1e-12;  // the point opposite the centre maps to a point far out
    const double scale = 2 / std::max(1 + dot(direction, centre_), kMin);
    return {scale * dot(direction, right_), scale * dot(direction, up_)};
}

Direction Chart::to_direction(Point plane) const {
    const double square = dot(plane, plane) / 4;
    return 1 / (1 + square) * ((1 - square) * centre_ + plane.x * right_ + plane.y * up_);
}

double Chart::ground(Point plane) const {
    const double conformal = conformal_tangent(to_direction(plane)), tangent = geodetic_tangent(conformal);
    const double square = tangent * tangent;
    // Ratio of the radii of the parallel on the ellipsoid, in metres, and on the unit sphere.
    const double radius = kEquatorialRadius * std::sqrt((1 + conformal * conformal) / (1 + square - kSquare * square));
    const double shrunk = radius / (1 + dot(plane, plane) / 4);
    return shrunk * shrunk;
}

}  // namespace ccdt
