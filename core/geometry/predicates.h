// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "core/geometry/delaunay.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Returns the exact sign of the signed area of triangle abc. Uses floating point where the error bound allows it, and
/// exact arithmetic otherwise. Source of the bounds: Shewchuk, Adaptive Precision Floating-Point Arithmetic, 1997,
/// section 4.
inline int orientation(Point a, Point b, Point c) {
    constexpr double kBound = 3.3306690738754716e-16;  // (3 + 16 e) e, e = 2^-53
    const double left = (a.x - c.x) * (b.y - c.y);
    const double right = (a.y - c.y) * (b.x - c.x);
    const double area = left - right;
    if (std::abs(area) > kBound * (std::abs(left) + std::abs(right))) return area > 0 ? 1 : -1;
    return exact_orientation(a, b, c);
}

/// Relative error bound of the in-circle determinant, as a multiple of its permanent: (10 + 96 e) e, e = 2^-53.
inline constexpr double kInCircleBound = 1.1102230246251577e-15;

/// Whether d lies strictly inside the circle through the counter-clockwise triangle abc. Exact.
inline bool in_circle(Point a, Point b, Point c, Point d) {
    const Point ad = a - d, bd = b - d, cd = c - d;
    const double bc1 = bd.x * cd.y, bc2 = cd.x * bd.y;
    const double ca1 = cd.x * ad.y, ca2 = ad.x * cd.y;
    const double ab1 = ad.x * bd.y, ab2 = bd.x * ad.y;
    const double a2 = dot(ad, ad), b2 = dot(bd, bd), c2 = dot(cd, cd);
    const double det = a2 * (bc1 - bc2) + b2 * (ca1 - ca2) + c2 * (ab1 - ab2);
    const double permanent = (std::abs(bc1) + std::abs(bc2)) * a2 + (std::abs(ca1) + std::abs(ca2)) * b2 +
                             (std::abs(ab1) + std::abs(ab2)) * c2;
    if (std::abs(det) > kInCircleBound * permanent) return det > 0;
    return exact_in_circle(a, b, c, d) > 0;
}

}  // namespace ccdt
