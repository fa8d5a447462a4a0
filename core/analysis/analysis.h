#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/result.h"

namespace ccdt {

struct AnalysisOptions {
    double max_frequency = 4;  ///< 1 to 16, in units of sqrt(n / area)
};

/// Power of the frequencies (i / domain's width, j / domain's height), in cycles per unit, |i| <= (width - 1) / 2 and
/// |j| <= (height - 1) / 2. That of (0, 0) is left out, as 0.
struct Spectrum {
    int width = 0;               ///< odd
    int height = 0;              ///< odd
    std::vector<double> values;  ///< [width * height], row by row, both from the lowest frequency

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
    std::size_t points = 0;  ///< of each set

    double unit = 0;                    ///< of frequencies: sqrt(n / area), near the principal frequency
    std::vector<double> frequency;      ///< of the rings, in these units
    std::vector<double> power;          ///< mean over the ring
    std::vector<double> anisotropy_db;  ///< variance over squared mean in the ring; isotropic: -10 log10(sets)

    std::optional<double> low_frequency_power;  ///< mean power of the frequencies below 0.5, if there are any

    Spectrum spectrum;

    /// Nearest distances over that of the densest packing, sqrt(2 / (sqrt(3) n)) for unit area: each set's smallest and
    /// its mean, averaged over the sets.
    double min_distance = 0;
    double mean_distance = 0;
};

/// Measures the spectrum and the spacing of sets of points, by the conventions of Lagae and Dutre 2008.
///
/// Frequencies are those that fit the domain, (i / width, j / height). P = |F|^2 / n, averaged over the sets, where
/// F(f) = sum over points of e^(-2 pi i f.x). Rings are 1 / sqrt(area) wide: r takes the frequencies that r, in units
/// of that width, is nearest to, r >= 1; a ring of less than two pairs +-f is left out.
///
/// A rectangle is a window on a larger pattern: points are weighted by w, Hann's window along both axes (mean of w^2 is
/// 1), and P = |F - d W|^2 / (sum of w^2), W being the window's own transform and d the density, which also stands for
/// n above and is taken from the middle, four fifths of each side. Frequencies (i, j), |i| <= 1 and |j| <= 1, are under
/// the window's lobe and left out of curves and means; distances are plain ones. The window blurs: neighbouring
/// frequencies are correlated, so that anisotropy is to be compared with that of other windows only.
///
/// @param sets    [s][n], at least 1 set of at least 2 points, in the domain's coordinates, on its border at most
/// @param domain  a rectangle or a torus
/// Errors: Unusable for no sets, too few points, sets of different sizes, a point outside, a window with nothing in
/// its middle, or a spectrum of no rings; Malformed for an option out of range; LimitExceeded if the transform would
/// need more than kMaxTransformCells, that is max_frequency^2 n above 33 million; Stopped. `field` is the option's name
/// or a JSON Pointer below the sets: /set/point.
/// Same input, same bytes. The root of a power errs by less than 1e-9, or of lattices 1e-10 sqrt(n).
/// O(s (n + N log N)), N = 16 max_frequency^2 n cells of 16 bytes; 16,384 points to frequency 4 take about
/// 0.1 s. Above kMostCells, half a gigabyte, the frequencies are computed in parts, one after the other, on grids that
/// take no more, over which the points are spread anew each time: 2 million points to frequency 4 take 20 s, and 1.7 GB
/// with the spectrum, which has 2 bytes for each of the N cells.
///
/// Sources: Ulichney 1987; Bartlett 1955. Departure: the mean is taken out of windows.
Result<Analysis> analyse(std::span<const std::vector<Point>> sets, const Domain& domain, const AnalysisOptions& options,
                         const std::stop_token& stop = {});

/// Cells that the transform of a set may need in all, and those of the largest grid.
inline constexpr std::size_t kMaxTransformCells = std::size_t{1} << 29;
inline constexpr std::size_t kMostCells = std::size_t{1} << 25;

}  // namespace ccdt
