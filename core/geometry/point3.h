// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace ccdt {

/// A point or a vector in space.
struct Point3 {
    double x = 0;
    double y = 0;
    double z = 0;

    friend bool operator==(const Point3&, const Point3&) = default;
    friend Point3 operator+(Point3 a, Point3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Point3 operator-(Point3 a, Point3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Point3 operator*(double s, Point3 a) { return {s * a.x, s * a.y, s * a.z}; }
};

inline Point3 cross(Point3 a, Point3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double dot(Point3 a, Point3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline double length(Point3 a) {
    return std::sqrt(dot(a, a));
}

}  // namespace ccdt
