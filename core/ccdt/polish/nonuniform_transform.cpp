// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/nonuniform_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/elementary.h"
#include "core/geometry/axes.h"
#include "core/geometry/spreading.h"

namespace ccdt {
namespace {

constexpr int kWidth = 12;               // width of the kernel, in cells
constexpr std::size_t kPerPoll = 16384;  // points between polls of the stop token

double grid_side(double highest) {
    return std::max(4 * highest, 2.0 * kWidth);
}

/// Returns the reciprocal of the kernel's Fourier transform, at frequencies of 0 to `highest` per `cells` cells.
std::vector<double> unspreading(int highest, int cells) {
    std::vector<double> result;
    for (int k = 0; k <= highest; ++k) result.push_back(1 / semicircle_spectrum<kWidth>(k, cells));
    return result;
}

/// The cells along one axis over which a point is spread.
struct Footprint {
    std::array<std::size_t, kWidth> cells;
    std::array<double, kWidth> shares;
};

/// @param position  in [0, 1]
Footprint footprint_of(double position, int side) {
    Footprint footprint;
    const double centre = position * side;
    const int first = static_cast<int>(std::ceil(centre - 0.5 * kWidth));
    for (int c = 0; c < kWidth; ++c) {
        const auto slot = static_cast<std::size_t>(c);
        footprint.cells[slot] = static_cast<std::size_t>((first + c + side) % side);
        footprint.shares[slot] = semicircle<kWidth>(first + c - centre);
    }
    return footprint;
}

/// Calls add(cell, weight * share) for each cell of a grid over which a point is spread. A grid with one layer receives
/// the sums over z, so z is ignored.
/// @param cells  columns, rows, layers
template <class P, class Add>
void spread(const P& position, double weight, const std::array<int, 3>& cells, Add&& add) {
    const Footprint x = footprint_of(position.x, cells[0]);
    const Footprint y = footprint_of(position.y, cells[1]);
    const auto spread_layer = [&](std::size_t layer, double factor) {
        const std::size_t first = layer * static_cast<std::size_t>(cells[1]);
        for_taps(x.shares, y.shares, factor, [&](std::size_t row, std::size_t column, double share) {
            add((first + y.cells[row]) * static_cast<std::size_t>(cells[0]) + x.cells[column], share);
        });
    };
    if constexpr (kAxes<P> == 3) {
        if (cells[2] > 1) {
            const Footprint z = footprint_of(position.z, cells[2]);
            for (std::size_t k = 0; k < kWidth; ++k) spread_layer(z.cells[k], weight * z.shares[k]);
            return;
        }
    }
    spread_layer(0, weight);
}

}  // namespace

double NonuniformTransform::cells(double highest_x, double highest_y, double highest_z) {
    return grid_side(highest_x) * grid_side(highest_y) * (highest_z == 0 ? 1 : grid_side(highest_z));
}

NonuniformTransform::NonuniformTransform(int highest_x, int highest_y, int highest_z)
    : cells_{good_size(grid_side(highest_x)), good_size(grid_side(highest_y)),
             highest_z == 0 ? 1 : good_size(grid_side(highest_z))},
      unspread_{unspreading(highest_x, cells_[0]), unspreading(highest_y, cells_[1]),
                highest_z == 0 ? std::vector{1.0} : unspreading(highest_z, cells_[2])},
      transform_(cells_, inline_executor()) {}

template <class P>
void NonuniformTransform::run(const std::vector<BasicWeightedPoint<P>>& points, const std::stop_token& stop) {
    const auto grid = transform_.grid();
    std::ranges::fill(grid, 0.0);
    for (std::size_t p = 0; p < points.size(); ++p) {
        if (p % kPerPoll == 0 && stop.stop_requested()) return;
        spread(points[p].position, points[p].weight, cells_,
               [&](std::size_t cell, double share) { grid[cell] += share; });
    }
    if (!stop.stop_requested()) transform_.forward();
}
template void NonuniformTransform::run(const std::vector<WeightedPoint>&, const std::stop_token&);
template void NonuniformTransform::run(const std::vector<BasicWeightedPoint<Point3>>&, const std::stop_token&);

double NonuniformTransform::factor(int i, int j, int k) const {
    const auto at = [&](std::size_t axis, int frequency) {
        return unspread_[axis][static_cast<std::size_t>(std::abs(frequency))];
    };
    return at(0, i) * at(1, j) * at(2, k);
}

std::complex<double> NonuniformTransform::coefficient(int i, int j, int k) const {
    if (i < 0) return std::conj(coefficient(-i, -j, -k));
    const int row = (k < 0 ? k + cells_[2] : k) * cells_[1] + (j < 0 ? j + cells_[1] : j);
    return transform_.spectrum()[static_cast<std::size_t>(row) * (static_cast<std::size_t>(cells_[0]) / 2 + 1) +
                                 static_cast<std::size_t>(i)];
}

std::complex<double> NonuniformTransform::value(int i, int j, int k) const {
    return factor(i, j, k) * coefficient(i, j, k);
}

template <class P>
void ShiftedTransform::run(const std::vector<BasicWeightedPoint<P>>& points, const std::array<int, 3>& middle,
                           const std::stop_token& stop) {
    const auto real = real_.transform_.grid(), imaginary = imaginary_.transform_.grid();
    std::ranges::fill(real, 0.0);
    std::ranges::fill(imaginary, 0.0);
    for (std::size_t p = 0; p < points.size(); ++p) {
        if (p % kPerPoll == 0 && stop.stop_requested()) return;
        const auto& [position, weight] = points[p];
        double turns = 0;
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) turns += middle[axis] * along(position, axis);
        const double angle = -2 * std::numbers::pi * (turns - std::floor(turns));
        const double along_real = weight * elementary::cos(angle), along_imaginary = weight * elementary::sin(angle);
        spread(position, 1, real_.cells_, [&](std::size_t cell, double share) {
            real[cell] += along_real * share;
            imaginary[cell] += along_imaginary * share;
        });
    }
    for (NonuniformTransform* const part : {&real_, &imaginary_}) {
        if (!stop.stop_requested()) part->transform_.forward();
    }
}
template void ShiftedTransform::run(const std::vector<WeightedPoint>&, const std::array<int, 3>&,
                                    const std::stop_token&);
template void ShiftedTransform::run(const std::vector<BasicWeightedPoint<Point3>>&, const std::array<int, 3>&,
                                    const std::stop_token&);

std::complex<double> ShiftedTransform::value(int i, int j, int k) const {
    return real_.factor(i, j, k) *
           (real_.coefficient(i, j, k) + std::complex<double>(0, 1) * imaginary_.coefficient(i, j, k));
}

}  // namespace ccdt
