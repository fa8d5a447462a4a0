// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

#include "core/geometry/axes.h"

namespace ccdt {

/// The layout of a grid over a box or torus, with a margin for points that are spread beyond the border. Cells that
/// follow each other along x form a line.
/// @tparam P  Point or Point3
template <class P>
struct GridFrame {
    /// Number of margin cells on each side of the grid; in the plane, there are none along z.
    static constexpr std::size_t kMargin = 3;

    bool torus = false;
    P sides;
    std::array<int, 3> cells{};  ///< without the margin

    /// Returns the number of periods that the wave with the lowest frequency has along an axis.
    double periods() const { return torus ? 1 : 0.5; }
    P cell() const {
        return by_axis<P>([&](std::size_t axis) { return along(sides, axis) / cells[axis]; });
    }

    std::size_t width() const { return static_cast<std::size_t>(cells[0]); }
    std::size_t lines() const { return static_cast<std::size_t>(cells[1]) * static_cast<std::size_t>(cells[2]); }

    static constexpr std::size_t margin(std::size_t axis) { return axis < kAxes<P> ? kMargin : 0; }
    /// Returns the number of cells with the margin.
    std::size_t padded(std::size_t axis) const { return static_cast<std::size_t>(cells[axis]) + 2 * margin(axis); }
    std::size_t padded_lines() const { return padded(1) * padded(2); }
    /// Converts the index of a line among the lines without the margin to its index among all lines.
    std::size_t padded_line(std::size_t line) const {
        const auto rows = static_cast<std::size_t>(cells[1]);
        return (margin(2) + line / rows) * padded(1) + margin(1) + line % rows;
    }
    /// Maps the padded index of a margin cell to the padded index of the cell that it repeats. Returns other indices
    /// unchanged.
    std::size_t folded(std::size_t index, std::size_t axis) const {
        const int count = cells[axis], i = static_cast<int>(index) - static_cast<int>(margin(axis));
        const int period = torus ? count : 2 * count, k = ((i % period) + period) % period;
        return margin(axis) + static_cast<std::size_t>(k < count ? k : period - 1 - k);
    }
};

}  // namespace ccdt
