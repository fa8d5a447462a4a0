// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/ccdt/relax/capacity_integral.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// A counter-clockwise triangle of a domain. By Green's theorem, each of its edges contributes to its mass.
struct Part {
    std::array<Point, 3> corners;
    std::array<double, 3> flows;  ///< contribution to the mass by the edge that begins at each corner

    double mass() const { return std::max(0.0, flows[0] + flows[1] + flows[2]); }
};

/// Divides a domain into ever smaller triangles of known mass. The mass is the exact integral of a density.
class Bisection {
public:
    /// @param density  must outlive this
    Bisection(const Domain& domain, const Density& density) : capacity_(domain, density) {}

    /// Returns the initial triangles: the two halves of a box, or for other domains, the triangles of the mesh.
    std::vector<Part> parts_of(const Domain& domain, const Triangulation& mesh) const;

    /// Divides a triangle in two across its longest edge. O(cells of the density crossed).
    std::array<Part, 2> halves(const Part& part) const;

    /// Returns the density at a point, in mass per area of the unit frame.
    double at(Point p) const { return capacity_.at(p); }

private:
    double flow(Point a, Point b) const;

    CapacityIntegral capacity_;
};

}  // namespace ccdt
