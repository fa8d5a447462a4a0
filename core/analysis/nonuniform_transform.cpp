// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/analysis/nonuniform_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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
    // The error of the trapezoidal rule is the kernel's content at frequencies above 1 / kStep - 1/4 per cell. That
    // content is negligible.
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

/// Returns the index of coefficient (i, j), i >= 0, in the spectrum of a grid.
std::size_t place_of(int i, int j, int columns, int rows) {
    const auto row = static_cast<std::size_t>(j < 0 ? j + rows : j);
    return row * (static_cast<std::size_t>(columns) / 2 + 1) + static_cast<std::size_t>(i);
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
    std::ranges::fill(transform_.grid(), 0.0);
    for (std::size_t p = 0; p < points.size(); ++p) {
        if (p % kPerPoll == 0 && stop.stop_requested()) return;
        spread(points[p]);
    }
    if (!stop.stop_requested()) transform_.forward();
}

void NonuniformTransform::spread(const WeightedPoint& point) {
    const Footprint x = footprint_of(point.position.x, columns_);
    const Footprint y = footprint_of(point.position.y, rows_);
    const auto grid = transform_.grid();
    for (std::size_t r = 0; r < kWidth; ++r) {
        const auto row = grid.subspan(y.cells[r] * static_cast<std::size_t>(columns_));
        const double share = point.weight * y.shares[r];
        for (std::size_t c = 0; c < kWidth; ++c) row[x.cells[c]] += share * x.shares[c];
    }
}

std::complex<double> NonuniformTransform::value(int i, int j) const {
    const double factor = unspread_x_[static_cast<std::size_t>(i)] * unspread_y_[static_cast<std::size_t>(std::abs(j))];
    return factor * transform_.spectrum()[place_of(i, j, columns_, rows_)];
}

ShiftedTransform::ShiftedTransform(int reach_x, int reach_y)
    : columns_(good_size(grid_side(reach_x))),
      rows_(good_size(grid_side(reach_y))),
      unspread_x_(unspreading(reach_x, columns_)),
      unspread_y_(unspreading(reach_y, rows_)),
      real_(columns_, rows_),
      imaginary_(columns_, rows_) {}

void ShiftedTransform::run(std::span<const WeightedPoint> points, int middle_x, int middle_y,
                           const std::stop_token& stop) {
    std::ranges::fill(real_.grid(), 0.0);
    std::ranges::fill(imaginary_.grid(), 0.0);
    for (std::size_t p = 0; p < points.size(); ++p) {
        if (p % kPerPoll == 0 && stop.stop_requested()) return;
        const auto& [position, weight] = points[p];
        const double turns = middle_x * position.x + middle_y * position.y;
        const double angle = -2 * std::numbers::pi * (turns - std::floor(turns));
        spread(position, weight * std::cos(angle), weight * std::sin(angle));
    }
    for (RealTransform* const part : {&real_, &imaginary_}) {
        if (!stop.stop_requested()) part->forward();
    }
}

void ShiftedTransform::spread(Point position, double real, double imaginary) {
    const Footprint x = footprint_of(position.x, columns_);
    const Footprint y = footprint_of(position.y, rows_);
    const auto real_grid = real_.grid(), imaginary_grid = imaginary_.grid();
    for (std::size_t r = 0; r < kWidth; ++r) {
        const std::size_t row = y.cells[r] * static_cast<std::size_t>(columns_);
        for (std::size_t c = 0; c < kWidth; ++c) {
            const double share = y.shares[r] * x.shares[c];
            real_grid[row + x.cells[c]] += real * share;
            imaginary_grid[row + x.cells[c]] += imaginary * share;
        }
    }
}

std::complex<double> ShiftedTransform::value(int i, int j) const {
    // Coefficients of a real grid at opposite frequencies are complex conjugates. So only one half of the coefficients
    // is stored.
    const bool is_opposite = i < 0;
    const std::size_t place = is_opposite ? place_of(-i, -j, columns_, rows_) : place_of(i, j, columns_, rows_);
    const double factor =
        unspread_x_[static_cast<std::size_t>(std::abs(i))] * unspread_y_[static_cast<std::size_t>(std::abs(j))];
    const auto sum = [&](const RealTransform& part) {
        const auto coefficient = part.spectrum()[place];
        return is_opposite ? std::conj(coefficient) : coefficient;
    };
    return factor * (sum(real_) + std::complex<double>(0, 1) * sum(imaginary_));
}

}  // namespace ccdt
