// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ccdt {

/// Histogram of a density that is constant on voxels. Four bins per octave of the density; bin 0 is for the density 0.
struct DensityHistogram {
    static constexpr std::size_t kBins = 176;

    /// Adds the next cell.
    /// @param value  relative to a reference that is of the order of the largest value
    void add(double value);

    std::vector<std::uint8_t> bins;          ///< [cells] bin of each cell, cells in the order of the grid
    std::array<double, kBins> masses{};      ///< [bins] sum of the values
    std::array<std::size_t, kBins> cells{};  ///< [bins] number of cells
};

/// Finds the steps of a density on voxels: values at which most of the density's contour runs between cells that are
/// clearly above and clearly below. Only steps that the sites resolve count: on both sides, there is area for several
/// sites, and the area is at least one spacing of the denser side wide on average.
/// @param cells     number of voxels along x, y and z
/// @param periodic  whether the first and the last cells along an axis are neighbours
/// @param sites     number of sites in the whole grid
/// @returns         number of steps that are below each voxel's density [cells]; empty if there is no step
///
/// O(cells).
std::vector<std::uint8_t> find_tiers(DensityHistogram histogram, const std::array<std::size_t, 3>& cells, bool periodic,
                                     double sites);

}  // namespace ccdt
