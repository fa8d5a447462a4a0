// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/executor.h"
#include "core/geometry/point3.h"

namespace ccdt::choice {

/// Shape of the set of candidates.
enum class Extent {
    Plane,    ///< all z are 0
    Surface,  ///< a surface in space, such as a sphere
    Solid,    ///< a volume
};

/// Candidates in a box from the origin. The grid of cells fits the box.
class CandidateCells {
public:
    /// Successive candidates in the order of rows().
    struct Range {
        std::size_t begin, end;
        std::size_t size() const { return end - begin; }
    };

    /// @param positions  [n >= 1] in the box; must outlive this object
    /// @param sides      sides of the box; the longest one is 1
    /// @param wanted     number of cells that should hold candidates, >= 1; fewer if there are fewer distinct positions
    ///
    /// O(n log n).
    CandidateCells(std::span<const Point3> positions, Point3 sides, Extent extent, double wanted, Executor& executor);

    /// Returns the numbers of the candidates, in order along a Morton curve.
    std::span<const std::uint32_t> rows() const { return rows_; }
    /// Returns the occupied cells.
    std::span<const Range> cells() const { return cells_; }
    /// Returns the centre of an occupied cell.
    Point3 centre(const Range& cell) const;
    /// Returns the area or, of a solid, the volume that a cell covers. Surfaces cross cells at any angle.
    double size() const { return size_; }

    /// Returns the blocks of 4 x 4 (x 4) cells, as ranges of cells().
    std::vector<Range> blocks() const;
    /// Returns the candidates from `begin` on that lie in the same small cell, whose side is at most `side`, except
    /// that it cannot be smaller than the resolution of the curve.
    Range small_cell(std::size_t begin, double side) const;

private:
    void set_grid(double side);
    template <class Key>
    void sort(Key&& key, Executor& executor);
    double side_of_cells(double wanted) const;

    std::span<const Point3> positions_;
    Point3 sides_, counts_;  ///< of the box; cells along each axis
    int fine_bits_ = 0;      ///< cells are divided into 2^fine_bits_ parts along each axis
    double finest_ = 1;      ///< longest side of these parts
    double size_ = 1;
    std::vector<std::uint64_t> keys_;  ///< positions on the curve, ascending
    std::vector<std::uint32_t> rows_;
    std::vector<Range> cells_;
};

}  // namespace ccdt::choice
