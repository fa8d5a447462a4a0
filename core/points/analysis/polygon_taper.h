// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <vector>

#include "core/base/fft.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// A taper over a domain of polygons: a weight that rises smoothly from 0 at the border to 1 where the distance from
/// the border, the depth, is largest. Weight = sin^2(pi / 2 * depth / largest depth).
///
/// Depths are computed for the cells of a grid, up to a cell too low. Between the centres of cells, depths and weights
/// are interpolated linearly; transform() is the transform of these same interpolated weights.
///
/// O(cells log cells), with at most about kMaxCells cells of 40 bytes.
class PolygonTaper {
public:
    static constexpr double kMaxCells = 1 << 21;

    /// @param domain  no torus
    explicit PolygonTaper(const Domain& domain);

    /// Whether the domain is at least some cells wide. If not, no other function may be called.
    bool is_wide_enough() const;

    /// Returns the weight at a position relative to the bounding box, with coordinates in [0, 1].
    double weight(Point share) const { return interpolate(weights_, share); }

    /// Returns the depth at such a position. The unit is the side of a square as large as the bounding box.
    double depth(Point share) const { return interpolate(depths_, share); }

    /// Returns the share of the domain where the depth is at least `depth`. O(log cells).
    double share_at_depth(double depth) const;

    /// Returns the mean over the bounding box of weight(s) e^(-2 pi i (i s.x + j s.y)).
    std::complex<double> transform(int i, int j) const;

private:
    /// @param cell  wanted side of the cells in the unit frame
    PolygonTaper(const Domain& domain, double cell);

    double interpolate(const std::vector<double>& values, Point share) const;

    int columns_, rows_;
    std::vector<double> depths_;   ///< [rows * columns] at the centres of cells, row by row
    std::vector<double> weights_;  ///< [rows * columns]
    std::vector<double> sorted_;   ///< depths of the cells inside, ascending
    double cell_ = 0;              ///< larger side of a cell, in the unit of depth()
    RealTransform transform_;
};

}  // namespace ccdt
