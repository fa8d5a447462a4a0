// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/geometry/point3.h"

namespace ccdt {

struct AnalysisOptions {
    double max_frequency = 4;  ///< 1 to 16, in units of sqrt(n / area) or, in space, cbrt(n / volume)
};

/// Power of the frequencies (i / domain's width, j / domain's height), in cycles per unit, for |i| <= (width - 1) / 2
/// and |j| <= (height - 1) / 2. In space, the frequency along z is 0. The value at (0, 0) is set to 0.
struct Spectrum {
    int width = 0;               ///< odd
    int height = 0;              ///< odd
    std::vector<double> values;  ///< [width * height], row by row; rows and columns start at the lowest frequency

    double& at(int i, int j) { return values[index(i, j)]; }
    double at(int i, int j) const { return values[index(i, j)]; }

private:
    std::size_t index(int i, int j) const {
        return static_cast<std::size_t>(j + height / 2) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(i + width / 2);
    }
};

/// Spectrum and spacing of sets of points, averaged by Bartlett's method. White noise has power 1.
struct Analysis {
    std::size_t sets = 0;
    std::size_t points = 0;  ///< number of points in each set

    double unit = 0;  ///< unit of frequencies, near the principal frequency: sqrt(n / area) or cbrt(n / volume)
    std::vector<double> frequency;      ///< frequencies of the rings or, in space, shells, in units of `unit`
    std::vector<double> power;          ///< mean power of each ring
    std::vector<double> anisotropy_db;  ///< variance / squared mean of each ring's power; -10 log10(sets) if isotropic

    /// Mean power of the frequencies below 0.5 or, in space, half the principal frequency, 0.5456; none if there are no
    /// such frequencies.
    std::optional<double> low_frequency_power;

    Spectrum spectrum;

    /// Least and mean distance of a set's points to their nearest neighbours, averaged over the sets. The unit is the
    /// hexagonal distance, sqrt(2 / (sqrt(3) n)) for unit area, or the face-centred cubic one, kCubicSpacing.
    double min_distance = 0;
    double mean_distance = 0;
};

/// Measures the spectrum and the spacing of sets of points, with the conventions of Lagae and Dutre 2008.
///
/// All frequencies (i / width, j / height) with whole numbers i and j are measured, because waves of these frequencies
/// fit the domain. P = |F|^2 / n, averaged over the sets, where F(f) = sum over points of e^(-2 pi i f.x). Frequencies
/// are grouped by magnitude into rings of width 1 / sqrt(area). Ring r >= 1 contains the frequencies whose magnitude,
/// in units of this width, is nearest to r. Rings with fewer than two pairs of opposite frequencies +-f are left out.
///
/// A rectangle is treated as a window on a larger pattern. Points are weighted by w, Hann's window along both axes (the
/// mean of w^2 is 1), and P = |F - d W|^2 / (sum of w^2). W is the window's own transform. d is the density in the
/// middle of the window, four fifths of each side; d times the area also replaces n above. Frequencies (i, j) with |i|
/// <= 1 and |j| <= 1 lie under the window's lobe and are left out of curves and means. Distances are not weighted. The
/// window correlates neighbouring frequencies, so its anisotropy is comparable only to the anisotropy of other windows.
///
/// Polygons are windows, too. Their window is PolygonTaper; d is the mean density, weighted by the window, and d times
/// the polygons' area replaces n. Frequencies (i, j) whose |W|^2 is above a twentieth of that at (0, 0) are left out.
/// The mean distance is Hanisch's estimate: only points that are nearer to their nearest neighbour than to the border
/// count, divided by the share of the area that is as far from the border. (The least distance is that of all points.)
/// So points cut out of a larger pattern have its spectrum and its mean distance. The largest distance from the border
/// must be at least a few thousandths of the extent.
///
/// @param sets    [s][n], at least 1 set of at least 2 points, in the domain's coordinates, inside or, in a box, on its
///                border
/// @param domain  any domain
///
/// Errors: Unusable for no sets, too few points, sets of different sizes, a point outside, a window without points in
/// its middle, polygons that are too narrow (`field` is "domain"), or a spectrum without rings; Malformed for an option
/// out of range; LimitExceeded if the transform would need more than kMaxTransformCells, i.e. max_frequency^2 n above
/// 33 million; Stopped. `field` is the option's name or a JSON Pointer relative to the sets: /set/point. Deterministic.
/// The error of the square root of a power is below 1e-9, or 1e-10 sqrt(n) for lattices. O(s (n + N log N)), with N =
/// 16 max_frequency^2 n cells of 16 bytes. With max_frequency = 4, 16,384 points take about 0.1 s. If N exceeds
/// kMaxCells (half a gigabyte), the frequencies are divided into parts. Each part is computed on a grid of at most this
/// size. The points are spread again for each part. With max_frequency = 4, 2 million points take 20 s and 1.7 GB. The
/// memory includes the spectrum, with 2 bytes for each of the N cells.
///
/// Sources: Ulichney 1987; Bartlett 1955; for distances in polygons, Hanisch 1984. Departure: the mean is subtracted
/// from windows.
Result<Analysis> analyse(std::span<const std::vector<Point>> sets, const Domain& domain, const AnalysisOptions& options,
                         const std::stop_token& stop = {});

/// Measures points in space in the same way, in a box from the origin or, if periodic, a torus. Differences:
/// frequencies (i, j, k) are grouped into shells of width 1 / cbrt(volume), and N = 64 max_frequency^3 n, so
/// max_frequency^3 n can be up to 8 million. With max_frequency = 2, 16,384 points take 0.3 s and 140 MB, 131,072
/// points take 3 s and 620 MB, and a million points take 80 s and 1.2 GB.
///
/// @param sides  Error::field is "domain" if they are not positive and finite
Result<Analysis> analyse(std::span<const std::vector<Point3>> sets, Point3 sides, bool periodic,
                         const AnalysisOptions& options, const std::stop_token& stop = {});

/// Checks the points, the domain and the options of an analysis. Errors: those of analyse(), except for Stopped, a
/// spectrum without rings, points outside polygons, and narrow polygons. O(points).
Result<void> check_analysis(std::span<const std::vector<Point>> sets, const Domain& domain,
                            const AnalysisOptions& options);
Result<void> check_analysis(std::span<const std::vector<Point3>> sets, Point3 sides, bool periodic,
                            const AnalysisOptions& options);

/// Largest number of cells that the transform of a set may need.
inline constexpr std::size_t kMaxTransformCells = std::size_t{1} << 29;

/// Largest number of cells of one grid.
inline constexpr std::size_t kMaxCells = std::size_t{1} << 25;

}  // namespace ccdt
