// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/analysis/nonuniform_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/geometry/spreading.h"

namespace ccdt {
namespace {

constexpr int kWidth = 12;               // width of the kernel, in cells
constexpr double kSteepness = 2.3;       // per cell of width; optimal for twice the resolution
constexpr std::size_t kPerPoll = 16384;  // points between polls of the stop token

/// Returns the kernel at a distance from its centre, in cells, of at most kWidth / 2.
double kernel(double distance) {
    const double share = 2 * distance / kWidth;
    return std::exp(kSteepness * kWidth * (std::sqrt(std::max(0.0, 1 - share * share)) - 1));
}

double grid_side(double highest) {
    return std::max(4 * highest, 2.0 * kWidth);
}

/// Returns the reciprocal of the kernel's Fourier transform, at frequencies of 0 to `highest` per `cells` cells.
std::vector<double> unspreading(int highest, int cells) {
    // The error of the trapezoidal rule is the kernel's content at frequencies above 1 / kStep - 1/4 per cell, which is
    // negligible.
    constexpr int kSteps = 4 * kWidth / 2;
    constexpr double kStep = 0.25;
    std::array<double, kSteps> heights;
    for (int s = 0; s < kSteps; ++s) heights[static_cast<std::size_t>(s)] = kernel(s * kStep);
    std::vector<double> result;
    for (int k = 0; k <= highest; ++k) {
        double sum = heights[0] / 2;
        for (int s = 1; s < kSteps; ++s) {
            sum += heights[static_cast<std::size_t>(s)] * std::cos(2 * std::numbers::pi * k * s * kStep / cells);
        }
        result.push_back(1 / (2 * kStep * sum));
    }
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
        footprint.shares[slot] = kernel(first + c - centre);
    }
    return footprint;
}

/// Calls add(cell, weight * share) for each cell of a grid over which a point is spread.
template <class Add>
void spread(const WeightedPoint& point, int columns, int rows, Add&& add) {
    const Footprint x = footprint_of(point.position.x, columns);
    const Footprint y = footprint_of(point.position.y, rows);
    for_taps(x.shares, y.shares, point.weight, [&](std::size_t row, std::size_t column, double share) {
        add(y.cells[row] * static_cast<std::size_t>(columns) + x.cells[column], share);
    });
}

}  // namespace

double NonuniformTransform::cells(double highest_x, double highest_y) {
    return grid_side(highest_x) * grid_side(highest_y);
}

NonuniformTransform::NonuniformTransform(int highest_x, int highest_y)
    : columns_(good_size(grid_side(highest_x))),
      rows_(good_size(grid_side(highest_y))),
      unspread_x_(unspreading(highest_x, columns_)),
      unspread_y_(unspreading(highest_y, rows_)),
      transform_(columns_, rows_) {}

void NonuniformTransform::run(std::span<const WeightedPoint> points, const std::stop_token& stop) {
    const auto grid = transform_.grid();
    std::ranges::fill(grid, 0.0);
    for (std::size_t p = 0; p < points.size(); ++p) {
        if (p % kPerPoll == 0 && stop.stop_requested()) return;
        spread(points[p], columns_, rows_, [&](std::size_t cell, double share) { grid[cell] += share; });
    }
    if (!stop.stop_requested()) transform_.forward();
}

double NonuniformTransform::factor(int i, int j) const {
    return unspread_x_[static_cast<std::size_t>(std::abs(i))] * unspread_y_[static_cast<std::size_t>(std::abs(j))];
}

std::complex<double> NonuniformTransform::coefficient(int i, int j) const {
    if (i < 0) return std::conj(coefficient(-i, -j));
    const auto row = static_cast<std::size_t>(j < 0 ? j + rows_ : j);
    return transform_.spectrum()[row * (static_cast<std::size_t>(columns_) / 2 + 1) + static_cast<std::size_t>(i)];
}

std::complex<double> NonuniformTransform::value(int i, int j) const {
    return factor(i, j) * coefficient(i, j);
}

void ShiftedTransform::run(std::span<const WeightedPoint> points, int middle_x, int middle_y,
                           const std::stop_token& stop) {
    const auto real = real_.transform_.grid(), imaginary = imaginary_.transform_.grid();
    std::ranges::fill(real, 0.0);
    std::ranges::fill(imaginary, 0.0);
    for (std::size_t p = 0; p < points.size(); ++p) {
        if (p % kPerPoll == 0 && stop.stop_requested()) return;
        const auto& [position, weight] = points[p];
        const double turns = middle_x * position.x + middle_y * position.y;
        const double angle = -2 * std::numbers::pi * (turns - std::floor(turns));
        const double along_real = weight * std::cos(angle), along_imaginary = weight * std::sin(angle);
        spread({position, 1}, real_.columns_, real_.rows_, [&](std::size_t cell, double share) {
            real[cell] += along_real * share;
            imaginary[cell] += along_imaginary * share;
        });
    }
    for (NonuniformTransform* const part : {&real_, &imaginary_}) {
        if (!stop.stop_requested()) part->transform_.forward();
    }
}

std::complex<double> ShiftedTransform::value(int i, int j) const {
    return real_.factor(i, j) * (real_.coefficient(i, j) + std::complex<double>(0, 1) * imaginary_.coefficient(i, j));
}

}  // namespace ccdt
