// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/wave_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ccdt {

namespace {

constexpr double kSteepness = 2.3;  ///< of the kernel, per cell of width; optimal for twice the resolution
constexpr std::size_t kLayers = 8;  ///< layers per slab; more than the three layers to which taps reach beyond a slab

std::variant<RealTransform, CosineTransform> make_transform(bool periodic, const std::array<int, 3>& cells,
                                                            Executor& executor) {
    if (periodic) return RealTransform(cells, executor);
    return CosineTransform(cells, executor);
}

/// Returns the kernel's Fourier transform, by the trapezoidal rule.
/// @param frequency  in cycles per cell
/// @param width      of the kernel, in cells
double window(double frequency, double width) {
    constexpr int kSteps = 64;
    const double step = width / 2 / kSteps;
    double sum = 0.5;
    for (int i = 1; i < kSteps; ++i) {
        const double share = static_cast<double>(i) / kSteps;
        sum += std::exp(kSteepness * width * (std::sqrt(1 - share * share) - 1)) *
               std::cos(2 * std::numbers::pi * frequency * i * step);
    }
    return 2 * step * sum;
}

}  // namespace

WaveGrid::WaveGrid(const BoxDomain3& domain, const Point3& cells, Executor& executor)
    : domain_(domain),
      executor_(executor),
      cells_{good_size(std::max<double>(cells.x, kMinCells)), good_size(std::max<double>(cells.y, kMinCells)),
             good_size(std::max<double>(cells.z, kMinCells))},
      sides_{domain.sides.x, domain.sides.y, domain.sides.z},
      transform_(make_transform(domain.periodic, cells_, executor)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const int kept = axis == 0 && domain.periodic ? cells_[0] / 2 + 1 : cells_[axis];
        for (int i = 0; i < kept; ++i) {
            const double cycles = frequency(static_cast<std::size_t>(i), axis) * sides_[axis] / cells_[axis];
            windows_[axis].push_back(window(cycles, kTaps));
        }
    }
}

/// Returns the frequency of a wave along an axis, in cycles per unit of length.
double WaveGrid::frequency(std::size_t number, std::size_t axis) const {
    const auto cycles = static_cast<double>(number), cells = static_cast<double>(cells_[axis]);
    if (!domain_.periodic) return cycles / (2 * sides_[axis]);
    return (2 * cycles > cells ? cycles - cells : cycles) / sides_[axis];
}

/// Returns the grid points over which a coordinate is spread. On a torus, grid points are at the corners of cells; in a
/// box, they are at the centres.
template <bool kSlopes>
WaveGrid::Taps WaveGrid::taps(double v, std::size_t axis) const {
    constexpr double kHalf = kTaps / 2.0;
    const int count = cells_[axis];
    const double at = v / sides_[axis] * count - (domain_.periodic ? 0 : 0.5);
    const double below = std::floor(at);
    const int first = static_cast<int>(below) - kTaps / 2 + 1;
    Taps taps;
    taps.in_row = first >= 0 && first + kTaps <= count;
    for (int t = 0; t < kTaps; ++t) {
        const auto slot = static_cast<std::size_t>(t);
        int cell = first + t;
        if (cell < 0) cell = domain_.periodic ? cell + count : -1 - cell;
        if (cell >= count) cell = domain_.periodic ? cell - count : 2 * count - 1 - cell;
        taps.cells[slot] = static_cast<std::size_t>(cell);
        const double share = (first + t - at) / kHalf, rest = std::sqrt(std::max(1e-6, 1 - share * share));
        taps.heights[slot] = std::exp(kSteepness * kTaps * (rest - 1));
        if constexpr (kSlopes) taps.slopes[slot] = taps.heights[slot] * kSteepness * kTaps / kHalf * share / rest;
    }
    return taps;
}

void WaveGrid::add(Point3 p, double value, double* values) const {
    const Taps x = taps<false>(p.x, 0), y = taps<false>(p.y, 1), z = taps<false>(p.z, 2);
    const auto columns = static_cast<std::size_t>(cells_[0]), rows = static_cast<std::size_t>(cells_[1]);
    for (std::size_t k = 0; k < kTaps; ++k) {
        for (std::size_t j = 0; j < kTaps; ++j) {
            double* const row = values + (z.cells[k] * rows + y.cells[j]) * columns;
            const double factor = value * z.heights[k] * y.heights[j];
            if (x.in_row) {
                double* const begin = row + x.cells[0];
                for (std::size_t i = 0; i < kTaps; ++i) begin[i] += factor * x.heights[i];
            } else {
                for (std::size_t i = 0; i < kTaps; ++i) row[x.cells[i]] += factor * x.heights[i];
            }
        }
    }
}

void WaveGrid::spread(std::span<const Point3> points, std::span<const double> weights) {
    values();
    for_ranges(executor_, values_.size(), 65536, [&](std::size_t begin, std::size_t end) {
        std::ranges::fill(values_.subspan(begin, end - begin), 0.0);
    });
    const auto layers = static_cast<std::size_t>(cells_[2]);
    const std::size_t slabs = layers / kLayers;
    const auto slab_of = [&](Point3 p) {
        const auto layer = static_cast<std::size_t>(p.z / sides_[2] * static_cast<double>(layers));
        return std::min(layer / kLayers, slabs - 1);
    };
    begins_.assign(slabs + 1, 0);
    order_.resize(points.size());
    for (const Point3 p : points) ++begins_[slab_of(p)];
    std::uint32_t sum = 0;
    for (std::uint32_t& begin : begins_) begin = sum += begin;
    for (std::size_t i = points.size(); i-- > 0;) order_[--begins_[slab_of(points[i])]] = static_cast<std::uint32_t>(i);
    // The taps of a slab reach only into adjacent slabs, and slabs of one phase are not adjacent. On a torus with an
    // odd number of slabs, the last one is adjacent to the first one, so it has a phase of its own.
    const bool has_last = domain_.periodic && slabs % 2 == 1 && slabs > 1;
    for (std::size_t phase = 0; phase < 3; ++phase) {
        executor_.run(slabs, [&](std::size_t slab) {
            if (phase != (has_last && slab == slabs - 1 ? 2 : slab % 2)) return;
            for (std::uint32_t k = begins_[slab]; k < begins_[slab + 1]; ++k) {
                const std::uint32_t i = order_[k];
                const double value = weights.empty() ? 1 : weights[i];
                if (value != 0) add(points[i], value, values_.data());
            }
        });
    }
}

Point3 WaveGrid::gradient(Point3 p) const {
    const Taps x = taps<true>(p.x, 0), y = taps<true>(p.y, 1), z = taps<true>(p.z, 2);
    const auto columns = static_cast<std::size_t>(cells_[0]), rows = static_cast<std::size_t>(cells_[1]);
    Point3 sum;
    for (std::size_t k = 0; k < kTaps; ++k) {
        double value_y = 0, slope_x = 0, slope_y = 0;
        for (std::size_t j = 0; j < kTaps; ++j) {
            const double* const row = values_.data() + (z.cells[k] * rows + y.cells[j]) * columns;
            double value = 0, slope = 0;
            if (x.in_row) {
                const double* const begin = row + x.cells[0];
                for (std::size_t i = 0; i < kTaps; ++i) value += x.heights[i] * begin[i];
                for (std::size_t i = 0; i < kTaps; ++i) slope += x.slopes[i] * begin[i];
            } else {
                for (std::size_t i = 0; i < kTaps; ++i) value += x.heights[i] * row[x.cells[i]];
                for (std::size_t i = 0; i < kTaps; ++i) slope += x.slopes[i] * row[x.cells[i]];
            }
            value_y += y.heights[j] * value;
            slope_y += y.slopes[j] * value;
            slope_x += y.heights[j] * slope;
        }
        sum = sum + Point3{z.heights[k] * slope_x, z.heights[k] * slope_y, z.slopes[k] * value_y};
    }
    return {sum.x * cells_[0] / sides_[0], sum.y * cells_[1] / sides_[1], sum.z * cells_[2] / sides_[2]};
}

void WaveGrid::forward() {
    std::visit([](auto& transform) { transform.forward(); }, transform_);
}

void WaveGrid::backward() {
    std::visit([](auto& transform) { transform.backward(); }, transform_);
}

void WaveGrid::release_memory() {
    std::visit([](auto& transform) { transform.release_memory(); }, transform_);
    values_ = {};
}

std::span<double> WaveGrid::values() {
    return values_ = std::visit([](auto& transform) { return transform.grid(); }, transform_);
}

}  // namespace ccdt
