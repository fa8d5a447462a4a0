// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/ccdt/polish/grid_frame.h"
#include "core/geometry/point3.h"
#include "core/geometry/spreading.h"

namespace ccdt {

/// The kernel of WaveGrid3: an "exponential of semicircle" along each axis, 6 cells wide. The error of a wave is 3e-6
/// at 1/6 cycle per cell, 5e-5 at 1/4 and 1e-3 at 0.3. So the power of waves can be reduced by 100 dB. With a B-spline
/// of this width, the error at 1/4 would be 1e-3. BasicWaveGrid documents the functions.
class SemicircleKernel {
public:
    static constexpr std::size_t kPointsPerTask = 512;
    static constexpr std::size_t kBand = 8;  ///< least number of layers in a band; more than the taps reach

    /// @param values  of the padded grid
    SemicircleKernel(const GridFrame<Point3>& frame, double* values)
        : frame_(frame), row_(frame.padded(0)), layer_(row_ * frame.padded(1)), values_(values) {}

    /// Returns the spectrum of the kernel along an axis.
    static double window(double periods, int cells) { return semicircle_spectrum<kTaps>(periods, cells); }

    /// Returns the padded layer of the first taps of a point.
    std::size_t first_layer(Point3 p) const { return position(p.z, 2).first; }

    /// @param numbers  indices of the points to spread
    void spread(std::span<const Point3> points, std::span<const double> values,
                std::span<const std::uint32_t> numbers) const {
        for (const std::uint32_t i : numbers) spread(points[i], values.empty() ? 1 : values[i]);
    }

    void gradients(std::span<const Point3> points, std::span<Point3> gradients) const {
        for (std::size_t i = 0; i < points.size(); ++i) gradients[i] = gradient(points[i]);
    }

private:
    static constexpr int kTaps = 6;

    struct Position {
        std::size_t first;  ///< padded index of the first grid point over which a coordinate is spread
        double offset;      ///< distance from there, in cells
    };
    struct Taps {
        std::size_t first;
        std::array<double, kTaps> heights, slopes;
    };

    /// Determines the grid points over which a coordinate is spread. On a torus, they are at the corners of cells; in a
    /// box, they are at the centres.
    Position position(double v, std::size_t axis) const {
        const int cells = frame_.cells[axis];
        const double share = v / along(frame_.sides, axis);
        const double at = frame_.torus ? (share - whole(share)) * cells : std::clamp(share, 0.0, 1.0) * cells - 0.5;
        // Rounding can put a position at the far end of a torus.
        const double below = std::min(whole(at), cells - 1.0);
        return {static_cast<std::size_t>(below + 1), at - below + 2};
    }

    template <bool kSlopes>
    Taps taps(double v, std::size_t axis) const {
        const Position position = this->position(v, axis);
        Taps taps;
        taps.first = position.first;
        for (std::size_t t = 0; t < kTaps; ++t) {
            const double distance = static_cast<double>(t) - position.offset, share = 2 * distance / kTaps;
            taps.heights[t] = semicircle<kTaps>(distance);
            if constexpr (kSlopes)  // as a function of the coordinate
                taps.slopes[t] =
                    taps.heights[t] * 2 * kSteepness * share / std::sqrt(std::max(1e-6, 1 - share * share));
        }
        return taps;
    }

    void spread(Point3 p, double value) const {
        const Taps x = taps<false>(p.x, 0), y = taps<false>(p.y, 1), z = taps<false>(p.z, 2);
        for (std::size_t k = 0; k < kTaps; ++k) {
            double* const corner = values_ + (z.first + k) * layer_ + y.first * row_ + x.first;
            for_taps(x.heights, y.heights, value * z.heights[k],
                     [&](std::size_t j, std::size_t i, double share) { corner[j * row_ + i] += share; });
        }
    }

    Point3 gradient(Point3 p) const {
        const Taps x = taps<true>(p.x, 0), y = taps<true>(p.y, 1), z = taps<true>(p.z, 2);
        Point3 sum;
        for (std::size_t k = 0; k < kTaps; ++k) {
            double value_y = 0, slope_x = 0, slope_y = 0;
            const double* row = values_ + (z.first + k) * layer_ + y.first * row_ + x.first;
            for (std::size_t j = 0; j < kTaps; ++j, row += row_) {
                double value = 0, slope = 0;
                for (std::size_t i = 0; i < kTaps; ++i) value += x.heights[i] * row[i];
                for (std::size_t i = 0; i < kTaps; ++i) slope += x.slopes[i] * row[i];
                value_y += y.heights[j] * value;
                slope_y += y.slopes[j] * value;
                slope_x += y.heights[j] * slope;
            }
            sum = sum + Point3{z.heights[k] * slope_x, z.heights[k] * slope_y, z.slopes[k] * value_y};
        }
        const Point3 cell = frame_.cell();
        return {sum.x / cell.x, sum.y / cell.y, sum.z / cell.z};
    }

    GridFrame<Point3> frame_;
    std::size_t row_, layer_;  ///< distance between rows and between layers of the padded grid, in values
    double* values_;
};

}  // namespace ccdt
