// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/density/density.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace ccdt {

namespace {

/// Multiplies values by the power of two that brings the largest value into [1, 2).
class Scaling {
public:
    /// @param largest  > 0, finite
    explicit Scaling(double largest) {
        const int exponent = -std::ilogb(largest);
        // Two factors, since at the ends of a double's range the power of two has no representable inverse.
        first_ = std::ldexp(1.0, exponent / 2);
        second_ = std::ldexp(1.0, exponent - exponent / 2);
    }

    double operator()(double value) const {
        const double scaled = value * first_ * second_;
        return scaled < Density::kMin ? 0 : scaled;
    }

private:
    double first_;
    double second_;
};

/// Returns the largest value. Errors: Malformed if any value is negative or not finite; Unusable if all are zero.
template <class T>
Result<double> largest_of(std::span<const T> values) {
    double largest = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto value = static_cast<double>(values[i]);
        if (!(value >= 0) || !std::isfinite(value)) {
            return failure(ErrorCode::Malformed, "a density's values must be finite and not negative",
                           "values/" + std::to_string(i));
        }
        largest = std::max(largest, value);
    }
    if (!(largest > 0)) return failure(ErrorCode::Unusable, "the density is zero everywhere", "values");
    return largest;
}

}  // namespace

template <class T>
Result<Density> Density::make(int width, int height, std::span<const T> values) {
    if (width < 1 || height < 1)
        return failure(ErrorCode::Malformed, "a density needs at least one column and one row");
    const auto columns = static_cast<std::size_t>(width);
    const auto rows = static_cast<std::size_t>(height);
    if (values.size() != columns * rows) {
        return failure(ErrorCode::Malformed,
                       "a density of " + std::to_string(width) + " x " + std::to_string(height) + " needs " +
                           std::to_string(columns * rows) + " values, not " + std::to_string(values.size()),
                       "values");
    }
    const auto largest = largest_of(values);
    if (!largest) return tl::make_unexpected(largest.error());
    const Scaling scaled(*largest);
    Density density;
    density.width_ = width;
    density.height_ = height;
    density.largest_ = scaled(*largest);
    density.row_sums_.resize((columns + 1) * rows);
    for (std::size_t row = 0; row < rows; ++row) {
        double* sums = &density.row_sums_[row * (columns + 1)];
        double sum = sums[0] = 0;
        for (std::size_t column = 0; column < columns; ++column)
            sums[column + 1] = sum += scaled(static_cast<double>(values[row * columns + column]));
        density.total_ += sum;
    }
    return density;
}

Result<Density> Density::grid(int width, int height, std::span<const double> values) {
    return make(width, height, values);
}

Result<Density> Density::grid(int width, int height, std::span<const float> values) {
    return make(width, height, values);
}

std::span<const double> Density::row_sums(int row) const {
    const auto stride = static_cast<std::size_t>(width_) + 1;
    return {row_sums_.data() + static_cast<std::size_t>(row) * stride, stride};
}

CellBlock Density::support() const {
    CellBlock block{width_, height_, 0, 0};
    for (int row = 0; row < height_; ++row) {
        const auto sums = row_sums(row);
        if (!(sums.back() > 0)) continue;
        const auto first = std::ranges::upper_bound(sums, 0.0), last = std::ranges::lower_bound(sums, sums.back());
        block.left = std::min(block.left, static_cast<int>(first - sums.begin()) - 1);
        block.right = std::max(block.right, static_cast<int>(last - sums.begin()));
        block.low = std::min(block.low, row);
        block.high = row + 1;
    }
    return block;
}

void Density::resample_row(const CellBlock& block, int columns, int rows, int row, std::span<double> masses) const {
    const double cell_width = static_cast<double>(block.columns()) / columns;
    const double cell_height = static_cast<double>(block.rows()) / rows;
    const double low = block.low + row * cell_height, high = block.low + (row + 1) * cell_height;
    std::fill(masses.begin(), masses.end(), 0.0);
    for (int j = static_cast<int>(low); j < block.high && j < high; ++j) {
        const double overlap = std::min(high, j + 1.0) - std::max(low, static_cast<double>(j));
        const auto sums = row_sums(j);
        double before = sums[static_cast<std::size_t>(block.left)];
        for (std::size_t column = 0; column < masses.size(); ++column) {
            const double x = block.left + static_cast<double>(column + 1) * cell_width;
            const auto i = static_cast<std::size_t>(std::min(static_cast<int>(x), block.right - 1));
            const double upto = sums[i] + (x - static_cast<double>(i)) * (sums[i + 1] - sums[i]);
            masses[column] += std::max(0.0, upto - before) * overlap;
            before = upto;
        }
    }
}

}  // namespace ccdt
