// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/executor.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/picture/reduction.h"

namespace ccdt {

/// The triangles of a drawing, on which the spot function is defined.
///
/// They are those of the Delaunay triangulation of the sites and of their mirror images in the sides of the picture, so
/// that they cover the picture, and contours meet its sides at right angles.
class SpotTriangles {
public:
    /// @param sites  within the box
    /// O(n log n).
    SpotTriangles(std::span<const Point> sites, const Box& box);

    using Corners = std::array<Point, 3>;

    std::size_t count() const { return triangles_.size(); }

    /// Returns the corners of a triangle, counter-clockwise, where the box is [0, 1] x [0, 1].
    Corners corners(std::size_t triangle) const;

private:
    std::vector<Point> points_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
};

/// Values of the spot function at the centres of cells. Without sites, they are 1/2.
class SpotField {
public:
    static constexpr int kRowsOfBand = 32;

    /// @param triangles  must outlive this object
    SpotField(const SpotTriangles& triangles, const CellGrid& cells);

    /// Writes the values of some rows.
    /// @param values  [(end - first) * columns] replaced with values in [0, 1]
    /// O(cells of the rows + triangles that cross them).
    void paint(int first, int end, std::span<float> values) const;

    /// Returns all values [columns * rows]. Deterministic for any number of threads.
    std::vector<float> values(Executor& executor = inline_executor()) const;

private:
    const SpotTriangles& triangles_;
    CellGrid cells_;
    std::vector<std::vector<std::uint32_t>> bands_;  ///< triangles that cross each band of rows
};

}  // namespace ccdt
