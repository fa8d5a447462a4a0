// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "ccdt/abi.h"
#include "ccdt/control.h"
#include "ccdt/domain.h"
#include "ccdt/volume.h"

namespace ccdt::v2 {

/// Power of the frequencies (i / width of the domain, j / height of the domain), in cycles per unit of length. White
/// noise has power 1. The value at (0, 0) is 0.
struct PowerSpectrum {
    int width = 0;              ///< odd; i is from -(width / 2) to width / 2
    int height = 0;             ///< odd; j is from -(height / 2) to height / 2
    std::vector<double> power;  ///< [width * height] row by row; columns and rows start at the lowest frequency
};

/// Measures of how evenly points are spread, averaged over sets of points.
struct PointAnalysis {
    std::size_t sets = 0;
    std::size_t points = 0;  ///< number of points in each set
    double unit = 0;         ///< unit of frequencies, near the principal frequency: sqrt(n / area) or cbrt(n / volume)
    std::vector<double> frequency;      ///< [rings] radii of rings or shells in the spectrum, in units of `unit`
    std::vector<double> power;          ///< [rings] mean power of each ring
    std::vector<double> anisotropy_db;  ///< [rings] variance over squared mean of the power, in decibels
    /// Mean power below 0.5 units or, in space, 0.5456 units; none if there are no such frequencies.
    std::optional<double> low_frequency_power;
    /// Least and mean distance to the nearest neighbour, relative to the distance in the densest packing.
    double min_distance = 0;
    double mean_distance = 0;
    PowerSpectrum spectrum;
};

/// Measures the spectrum and the distances of sets of points.
///
/// @param sets           [s][n] at least one set of at least two points, in the domain or on its border
/// @param domain         a rectangle, which is treated as a window on a larger pattern, or a torus
/// @param max_frequency  largest frequency, 1 to 16, in units of sqrt(n / area)
/// @param control        only `stop` is used
///
/// Errors: Malformed for a domain of polygons, a frequency out of range, and a coordinate that is not finite; Unusable
/// for points outside the domain, for too few points, and for sets of different sizes; LimitExceeded if
/// max_frequency^2 n is above 33 million; Stopped.
///
/// Deterministic. O(s (n + N log N)) with N = 16 max_frequency^2 n.
///
/// Sources: Ulichney 1987; Bartlett 1955; Lagae and Dutre 2008.
CCDT_EXPORT PointAnalysis analyze(std::span<const std::vector<Point>> sets, const Domain& domain,
                                  double max_frequency = 4, const Control& control = {});

/// Measures points in space in the same way. `spectrum` is the slice at the frequency 0 along z.
///
/// @param domain         a box, which is treated as a window on a larger pattern, or a torus
/// @param max_frequency  largest frequency, 1 to 16, in units of cbrt(n / volume)
///
/// Errors: as above, but Malformed for a solid, and LimitExceeded if max_frequency^3 n is above 8 million.
CCDT_EXPORT PointAnalysis analyze(std::span<const std::vector<Point3>> sets, const VolumeDomain& domain,
                                  double max_frequency = 2, const Control& control = {});

/// Measures the spectrum and the distances of one set of points.
CCDT_EXPORT PointAnalysis analyze(const std::vector<Point>& points, const Domain& domain, double max_frequency = 4,
                                  const Control& control = {});
CCDT_EXPORT PointAnalysis analyze(const std::vector<Point3>& points, const VolumeDomain& domain,
                                  double max_frequency = 2, const Control& control = {});

}  // namespace ccdt::v2
