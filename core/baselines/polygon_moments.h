// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Integrals of a weight, and of the weight times the offset from a point.
struct Moments {
    double mass = 0;
    Point first;
    double magnitude = 0;  ///< sum of the absolute values whose signed sum is `mass`; bounds the rounding error of
                           ///< `mass`

    void add(const Moments& other) {
        mass += other.mass;
        first = first + other.first;
        magnitude += other.magnitude;
    }
};

/// Integrates the square of a density over polygons. Exact by Green's theorem, since the density is constant on its
/// cells. Grids of more than 4 million cells are averaged in blocks.
class SquaredDensity {
public:
    SquaredDensity(const Domain& domain, const Density& density);

    /// @param corners  corners of the polygon, counter-clockwise, in the unit frame, within the domain's bounding box
    /// @param from     reference point of the first moment
    ///
    /// O(corners + cells crossed).
    Moments over(std::span<const Point> corners, Point from) const;

private:
    Moments along(Point a, Point b) const;

    int columns_ = 0;  ///< 0 if uniform
    int rows_ = 0;
    Point to_grid_{1, 1};            ///< cells per unit
    std::vector<double> sums_;       ///< [rows][columns + 1] sums of squares left of each column
    std::vector<double> x_moments_;  ///< [rows][columns + 1] sums of square * x of the cell's centre
};

}  // namespace ccdt
