// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <utility>

#include "core/surface/surface.h"
#include "core/volume/solid.h"
#include "tests/support/surfaces.h"

namespace ccdt::test {

inline TriangleSoup moved(TriangleSoup soup, double scale, Point3 by) {
    for (Point3& p : soup.vertices) p = scale * p + by;
    return soup;
}

/// Returns a soup with the other orientation.
inline TriangleSoup turned_over(TriangleSoup soup) {
    for (auto& triangle : soup.triangles) std::swap(triangle[1], triangle[2]);
    return soup;
}

inline Surface surface_of(const TriangleSoup& soup) {
    return std::move(Surface::create(soup, std::nullopt)->surface);
}

inline Solid solid_of(const TriangleSoup& soup) {
    return *Solid::create(surface_of(soup));
}

}  // namespace ccdt::test
