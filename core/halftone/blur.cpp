#include "core/halftone/blur.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace ccdt {

namespace {

constexpr int kBoxes = 2;

/// Weighs 2 * reach + 1 values alike, and one more at each end by a share of that.
struct Box {
    /// Of a variance.
    explicit Box(double variance)
        : reach(static_cast<int>((std::sqrt(12 * variance + 1) - 1) / 2)),
          end((2 * reach + 1) * (reach * (reach + 1.0) - 3 * variance) /
              (6 * (variance - (reach + 1.0) * (reach + 1.0)))),
          weight(1 / (2 * reach + 1 + 2 * end)) {}

    int reach;
    double end;
    double weight;
};

Box box_of(double sigma, int side) {
    const double most = std::min(sigma, 0.5 * side);
    return Box(most * most / kBoxes);
}

/// The place in [0, side) that a place beyond the sides mirrors.
int mirrored(int place, int side) {
    const int period = 2 * side;
    const int within = ((place % period) + period) % period;
    return within < side ? within : period - 1 - within;
}

/// Filters all columns of a plane.
void filter_columns(const Box& box, int width, int height, const float* from, float* to) {
    const auto columns = static_cast<std::size_t>(width);
    const auto row = [&](int y) { return from + static_cast<std::size_t>(mirrored(y, height)) * columns; };
    std::vector<double> sums(columns);  // of the values in reach
    for (int y = -box.reach; y <= box.reach; ++y) {
        for (std::size_t x = 0; x < columns; ++x) sums[x] += static_cast<double>(row(y)[x]);
    }
    for (int y = 0; y < height; ++y) {
        const float *before = row(y - box.reach - 1), *first = row(y - box.reach), *after = row(y + box.reach + 1);
        float* out = to + static_cast<std::size_t>(y) * columns;
        for (std::size_t x = 0; x < columns; ++x) {
            const double ends = static_cast<double>(before[x]) + static_cast<double>(after[x]);
            out[x] = static_cast<float>(box.weight * (sums[x] + box.end * ends));
            sums[x] += static_cast<double>(after[x]) - static_cast<double>(first[x]);
        }
    }
}

/// Filters one row in place.
/// @param padded  room for the row and what its sides mirror
void filter_row(const Box& box, int width, float* row, std::vector<float>& padded) {
    const int margin = box.reach + 1;
    padded.resize(static_cast<std::size_t>(width + 2 * margin));
    std::copy_n(row, width, padded.begin() + margin);
    for (int x = 1; x <= margin; ++x) {
        padded[static_cast<std::size_t>(margin - x)] = row[mirrored(-x, width)];
        padded[static_cast<std::size_t>(margin + width - 1 + x)] = row[mirrored(width - 1 + x, width)];
    }
    double sum = 0;
    for (int x = 1; x <= 2 * box.reach + 1; ++x) sum += static_cast<double>(padded[static_cast<std::size_t>(x)]);
    const float* before = padded.data();
    const float* after = before + 2 * margin;
    for (int x = 0; x < width; ++x) {
        const double ends = static_cast<double>(before[x]) + static_cast<double>(after[x]);
        row[x] = static_cast<float>(box.weight * (sum + box.end * ends));
        sum += static_cast<double>(after[x]) - static_cast<double>(before[x + 1]);
    }
}

}  // namespace

std::vector<float> blurred(const std::vector<float>& values, int width, int height, double sigma) {
    assert(sigma >= 0 && values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    std::vector<float> plane(values.size()), other(values.size());
    const Box down = box_of(sigma, height), across = box_of(sigma, width);
    filter_columns(down, width, height, values.data(), other.data());
    filter_columns(down, width, height, other.data(), plane.data());
    for (auto row = plane.begin(); row != plane.end(); row += width) {
        for (int i = 0; i < kBoxes; ++i) filter_row(across, width, &*row, other);
    }
    return plane;
}

}  // namespace ccdt
