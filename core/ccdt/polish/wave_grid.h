// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdlib>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/executor.h"
#include "core/base/fft.h"
#include "core/ccdt/polish/grid_frame.h"
#include "core/geometry/axes.h"

namespace ccdt {

/// A grid over a box or torus, in the plane or in space, and its transform. On a torus, this is the Fourier transform.
/// In a box, it is the cosine transform, which corresponds to a grid that is mirrored at its sides. A kernel spreads
/// points onto the grid, and reads values from it: SplineKernel in the plane, SemicircleKernel in space. Spreading and
/// transforming, followed by a division by the spectrum of the kernel, window(), is a non-uniform transform. The
/// kernels document its error.
///
/// The results do not depend on the number of threads. Needs 8 bytes per cell of the grid with its margin of 3 cells
/// and, on a torus, another 8 bytes per cell without the margin.
///
/// Source: Beylkin, On the fast Fourier transform of functions with singularities, 1995.
/// @tparam P  Point or Point3
template <class P>
class BasicWaveGrid {
public:
    /// Periods along x, y and z; in a box, half periods. In the plane, there are none along z.
    using Wave = std::array<int, 3>;
    /// Factors of waves: [axes][periods along the axis]
    using Factors = std::array<std::vector<double>, kAxes<P>>;

    /// @param sides     size of the box, > 0
    /// @param cells     along x, y and z, even, >= 6; see good_size(); in the plane, a single one along z
    /// @param executor  runs operations on the whole grid and on many points; must outlive this object
    BasicWaveGrid(bool torus, P sides, const std::array<int, 3>& cells, Executor& executor = inline_executor());

    const std::array<int, 3>& cells() const { return frame_.cells; }
    P cell() const { return frame_.cell(); }

    /// Releases the memory. The next call must be clear() or grid(), which allocates the memory again.
    void release_memory() {
        std::visit([](auto& transform) { transform.release_memory(); }, transform_);
        padded_ = {};
    }
    /// Sets all values to 0. Must be called before the first spread().
    void clear();
    /// Adds points with values.
    /// @param points  inside the box; on a torus, any periodic copy
    /// @param values  [points]; empty: 1 each
    void spread(std::span<const P> points, std::span<const double> values);
    /// Adds the changes of the grid values, to first order, if points with value 1 that were spread make moves. This is
    /// the transpose of gradients(), apart from the factor window(). Only in the plane.
    void spread_moves(std::span<const P> points, std::span<const P> moves);
    /// Computes the coefficients of the spread values.
    void transform() {
        fold();
        forward();
    }

    /// Transforms coefficients to the values that gradients() reads.
    void transform_back() {
        backward();
        unfold();
    }
    /// Computes the gradients at points, per unit of length, of the function whose coefficients transform_back() has
    /// transformed. The coefficients must have been divided by window() before.
    /// @param gradients  out [points]; may be the memory of `points`
    void gradients(std::span<const P> points, std::span<P> gradients) const;

    /// Returns the values of the cells, along x, then y, then z, for transforms without the kernel. forward()
    /// transforms these values to coefficients, and backward() transforms back. Both together multiply the values by
    /// scale().
    std::span<double> grid() {
        acquire_memory();
        return std::visit([](auto& transform) { return transform.grid(); }, transform_);
    }
    void forward() {
        std::visit([](auto& transform) { transform.forward(); }, transform_);
    }
    void backward() {
        std::visit([](auto& transform) { transform.backward(); }, transform_);
    }
    double scale() const { return copies() * static_cast<double>(frame_.lines() * frame_.width()); }

    /// Calls visit(coefficients) with a span of double (box) or std::complex<double> (torus); order: for_waves().
    template <class Visit>
    void with_coefficients(Visit&& visit) {
        if (auto* fourier = std::get_if<RealTransform>(&transform_)) {
            visit(fourier->spectrum());
        } else {
            visit(std::get<CosineTransform>(transform_).grid());
        }
    }

    /// Calls visit(number of the coefficient, wave) for all waves, some calls in parallel. The periods along y
    /// and z may be negative. Skips aliased waves.
    template <class Visit>
    void for_waves(Visit&& visit) const {
        for_ranges(executor_, frame_.lines(), kLines, [&](std::size_t begin, std::size_t end) {
            const auto is_aliased = [&](const Wave& wave, std::size_t axis) {
                return frame_.torus && 2 * wave[axis] == frame_.cells[axis];
            };
            for (std::size_t line = begin; line < end; ++line) {
                Wave wave = first_wave(line);
                if (is_aliased(wave, 1) || is_aliased(wave, 2)) continue;
                for (std::size_t i = 0; i < line_size(); ++i, ++wave[0])
                    if (!is_aliased(wave, 0)) visit(line * line_size() + i, std::as_const(wave));
            }
        });
    }

    std::size_t coefficient_count() const { return frame_.lines() * line_size(); }
    /// Returns the number of successive coefficients whose waves differ only in the periods along x.
    std::size_t line_size() const { return windows_[0].size(); }
    /// Returns the wave of the first coefficient in a line.
    Wave first_wave(std::size_t line) const {
        const auto periods = [&](int position, std::size_t axis) {
            return frame_.torus && 2 * position > frame_.cells[axis] ? position - frame_.cells[axis] : position;
        };
        const auto rows = static_cast<std::size_t>(frame_.cells[1]);
        return {0, periods(static_cast<int>(line % rows), 1), periods(static_cast<int>(line / rows), 2)};
    }
    /// Returns the number of a wave's coefficient.
    std::size_t number(const Wave& wave) const {
        const auto position = [&](std::size_t axis) {
            return static_cast<std::size_t>(wave[axis] < 0 ? wave[axis] + frame_.cells[axis] : wave[axis]);
        };
        return (position(2) * static_cast<std::size_t>(frame_.cells[1]) + position(1)) * line_size() + position(0);
    }

    /// Returns the frequency in cycles per unit of length.
    P frequency(const Wave& wave) const {
        return by_axis<P>([&](std::size_t axis) { return frame_.periods() * wave[axis] / along(frame_.sides, axis); });
    }

    /// Returns the factor by which spreading multiplies a coefficient.
    double window(const Wave& wave) const { return product(1, windows_, wave); }

    /// Returns function(frequency, axis) for all frequencies along each axis.
    template <class Function>
    Factors along_axes(Function&& function) const {
        Factors values = windows_;
        for (std::size_t axis = 0; axis < values.size(); ++axis) {
            Wave wave{};
            for (double& value : values[axis]) {
                value = function(along(frequency(wave), axis), axis);
                ++wave[axis];
            }
        }
        return values;
    }
    /// Returns `first`, multiplied by a wave's factors along all axes.
    static double product(double first, const Factors& factors, const Wave& wave) {
        for (std::size_t axis = 0; axis < factors.size(); ++axis)
            first *= factors[axis][static_cast<std::size_t>(std::abs(wave[axis]))];
        return first;
    }

    /// Returns the ratio of a coefficient to the integral that it represents.
    double copies() const { return frame_.torus ? 1 : 1 << kAxes<P>; }

private:
    void acquire_memory() {
        if (padded_.empty()) padded_ = std::visit([](auto& transform) { return transform.spare(); }, transform_);
    }
    void fold();
    void unfold();
    template <class Visit>
    void for_margins(Visit&& visit) const;
    template <class Visit>
    void for_margin_lines(Visit&& visit);
    template <class Counts, class Add>
    void add_all(std::span<const P> points, Counts&& counts, Add&& add);

    static constexpr std::size_t kLines = 16;  ///< lines per task

    Executor& executor_;
    GridFrame<P> frame_;
    Factors windows_;
    std::variant<RealTransform, CosineTransform> transform_;
    /// The grid with its margin, in the memory of the spectrum (torus) or of the grid (box).
    std::span<double> padded_;
};

extern template class BasicWaveGrid<Point>;
extern template class BasicWaveGrid<Point3>;

using WaveGrid = BasicWaveGrid<Point>;
using WaveGrid3 = BasicWaveGrid<Point3>;

}  // namespace ccdt
