#include "core/density/density.h"

#include <algorithm>
#include <string>

namespace ccdt {

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
    Density density;
    density.width_ = width;
    density.height_ = height;
    density.row_sums_.resize((columns + 1) * rows);
    for (std::size_t row = 0; row < rows; ++row) {
        double* sums = &density.row_sums_[row * (columns + 1)];
        double sum = sums[0] = 0;
        for (std::size_t column = 0; column < columns; ++column) {
            const auto value = static_cast<double>(values[row * columns + column]);
            if (!(value >= 0) || !(value <= kMaxValue)) {
                return failure(ErrorCode::Malformed, "a density's values must lie between 0 and 1e100",
                               "values/" + std::to_string(row * columns + column));
            }
            sums[column + 1] = sum += value;
            density.largest_ = std::max(density.largest_, value);
        }
        density.total_ += sum;
    }
    if (!(density.total_ > 0)) return failure(ErrorCode::Unusable, "the density is zero everywhere", "values");
    return density;
}

Result<Density> Density::grid(int width, int height, std::span<const double> values) {
    return make(width, height, values);
}

Result<Density> Density::grid(int width, int height, std::span<const float> values) {
    return make(width, height, values);
}

double Density::value(int column, int row) const {
    const auto sums = row_sums(row);
    const auto i = static_cast<std::size_t>(column);
    return sums[i + 1] - sums[i];
}

std::span<const double> Density::row_sums(int row) const {
    const auto stride = static_cast<std::size_t>(width_) + 1;
    return std::span(row_sums_).subspan(static_cast<std::size_t>(row) * stride, stride);
}

}  // namespace ccdt
