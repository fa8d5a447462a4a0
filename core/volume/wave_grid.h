// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "core/fourier/fft.h"
#include "core/geometry/point3.h"
#include "core/parallel/executor.h"
#include "core/volume/box_domain3.h"

namespace ccdt {

/// A grid in space that transforms points to waves, and waves to gradients at points, as SplineGrid does in the plane.
/// The waves of a torus are periodic; those of a box are cosines, which are mirrored at its faces.
///
/// Each point is spread over 6 x 6 x 6 grid points. With a B-spline of this width as kernel, the error of a wave at a
/// quarter of the grid's frequency would be 1e-3. With the "exponential of semicircle" kernel, it is 5e-5, 1e-3 at 0.3
/// times the grid's frequency, and 3e-6 at a sixth, so that the power of waves can be reduced by 100 dB. Source:
/// Barnett, Magland, af Klinteberg 2019.
///
/// The results do not depend on the number of threads. 16 bytes per cell (torus) or 8 (box).
class WaveGrid {
public:
    static constexpr int kMinCells = 8;  ///< least number of cells along each axis

    /// @param cells     least number of cells along each axis, at most 1e9
    /// @param executor  runs the steps; must outlive this object
    WaveGrid(const BoxDomain3& domain, const Point3& cells, Executor& executor);

    /// Replaces the grid's values by points with weights.
    /// @param points   in the domain
    /// @param weights  [points]; empty: 1 each
    void spread(std::span<const Point3> points, std::span<const double> weights);

    /// Transforms the grid's values to coefficients, and back. Both together multiply the values by copies() * cells.
    void forward();
    void backward();

    /// Releases the memory until the next spread() or values().
    void release_memory();

    std::span<double> values();
    const std::array<int, 3>& cells() const { return cells_; }

    /// Returns the gradient, per unit of length, of the function whose coefficients backward() has transformed. These
    /// must have been divided by Wave::window before.
    Point3 gradient(Point3 p) const;

    /// Factor by which forward() multiplies the sum over points that a coefficient represents.
    double copies() const { return domain_.periodic ? 1 : 8; }

    /// A wave, by its frequency in cycles per unit of length.
    struct Wave {
        std::size_t number;  ///< index of its coefficient
        Point3 frequency;
        double window;  ///< factor by which spreading multiplies the coefficient
        bool aliased;   ///< whether the grid cannot tell the wave from its mirror image
    };

    /// Calls visit(coefficients, wave, layer) for all waves, those of different layers possibly in parallel.
    /// Coefficients are a span of std::complex<double> (torus) or double (box).
    template <class Visit>
    void for_waves(Visit&& visit) {
        if (auto* fourier = std::get_if<RealTransform>(&transform_)) {
            for_waves(fourier->spectrum(), visit);
        } else {
            for_waves(std::get<CosineTransform>(transform_).grid(), visit);
        }
    }

private:
    static constexpr int kTaps = 6;

    /// The six grid points along an axis over which a point is spread.
    struct Taps {
        std::array<std::size_t, kTaps> cells;
        std::array<double, kTaps> heights, slopes;
        bool in_row;  ///< whether the grid points are successive
    };

    template <class Coefficients, class Visit>
    void for_waves(Coefficients coefficients, Visit&& visit) {
        const std::size_t columns = windows_[0].size();
        for_ranges(executor_, static_cast<std::size_t>(cells_[2]), 1, [&](std::size_t layer, std::size_t) {
            const double z = frequency(layer, 2);
            for (std::size_t row = 0; row < static_cast<std::size_t>(cells_[1]); ++row) {
                const std::size_t first = (layer * static_cast<std::size_t>(cells_[1]) + row) * columns;
                const double y = frequency(row, 1), window = windows_[1][row] * windows_[2][layer];
                const bool aliased = is_aliased(row, 1) || is_aliased(layer, 2);
                for (std::size_t i = 0; i < columns; ++i) {
                    const Wave wave{
                        first + i, {frequency(i, 0), y, z}, window * windows_[0][i], aliased || is_aliased(i, 0)};
                    visit(coefficients, wave, layer);
                }
            }
        });
    }

    double frequency(std::size_t number, std::size_t axis) const;
    bool is_aliased(std::size_t number, std::size_t axis) const {
        return domain_.periodic && 2 * number == static_cast<std::size_t>(cells_[axis]);
    }
    template <bool kSlopes>
    Taps taps(double v, std::size_t axis) const;
    void add(Point3 p, double value, double* values) const;

    BoxDomain3 domain_;
    Executor& executor_;
    std::array<int, 3> cells_;
    std::array<double, 3> sides_;
    std::array<std::vector<double>, 3> windows_;
    std::variant<RealTransform, CosineTransform> transform_;
    std::span<double> values_;
    std::vector<std::uint32_t> order_, begins_;  ///< points sorted by slabs of layers, and the start of each slab
};

}  // namespace ccdt
