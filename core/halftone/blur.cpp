// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/blur.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "core/halftone/pixel_ranges.h"

namespace ccdt {

namespace {

constexpr int kBoxes = 2;

/// Number of columns filtered together, so that their sums stay in the cache.
constexpr std::size_t kColumns = 256;

/// Number of rows filtered together, so that their chains of dependent additions run at the same time.
constexpr std::size_t kRows = 4;

/// Box filter of 2 * reach + 1 equal weights, and one further weight at each end, smaller by the factor `end`.
struct Box {
    /// Constructs the filter that has exactly the given variance, in squared pixels.
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

/// Returns the index in [0, side) of the pixel whose mirror image lies at `place`.
int mirrored(int place, int side) {
    const int period = 2 * side;
    const int within = ((place % period) + period) % period;
    return within < side ? within : period - 1 - within;
}

/// Filters some adjacent columns of an image.
/// @param from, to  top of the first column, in the image and in the result
/// @param columns   at most kColumns
void filter_columns(const Box& box, int width, int height, const float* from, float* to, std::size_t columns) {
    const auto stride = static_cast<std::size_t>(width);
    const auto row = [&](int y) { return from + static_cast<std::size_t>(mirrored(y, height)) * stride; };
    std::array<double, kColumns> sums{};  // sums of the values within reach
    for (int y = -box.reach; y <= box.reach; ++y) {
        for (std::size_t x = 0; x < columns; ++x) sums[x] += static_cast<double>(row(y)[x]);
    }
    for (int y = 0; y < height; ++y) {
        const float *before = row(y - box.reach - 1), *first = row(y - box.reach), *after = row(y + box.reach + 1);
        float* out = to + static_cast<std::size_t>(y) * stride;
        for (std::size_t x = 0; x < columns; ++x) {
            const double ends = static_cast<double>(before[x]) + static_cast<double>(after[x]);
            out[x] = static_cast<float>(box.weight * (sums[x] + box.end * ends));
            sums[x] += static_cast<double>(after[x]) - static_cast<double>(first[x]);
        }
    }
}

/// Copies a row and extends it on both sides by mirrored pixels.
void pad(const float* row, int width, int margin, float* padded) {
    std::copy_n(row, width, padded + margin);
    for (int x = 1; x <= margin; ++x) {
        padded[margin - x] = row[mirrored(-x, width)];
        padded[margin + width - 1 + x] = row[mirrored(width - 1 + x, width)];
    }
}

/// Filters some rows in place.
/// @param padded  buffer for the extended rows
template <std::size_t kCount>
void filter_rows(const Box& box, int width, float* rows, std::vector<float>& padded) {
    const int margin = box.reach + 1;
    const auto columns = static_cast<std::size_t>(width), stride = columns + 2 * static_cast<std::size_t>(margin);
    padded.resize(kCount * stride);
    std::array<double, kCount> sums{};  // sums of the values within reach
    for (std::size_t row = 0; row < kCount; ++row) {
        const float* values = padded.data() + row * stride;
        pad(rows + row * columns, width, margin, padded.data() + row * stride);
        for (int x = 1; x <= 2 * box.reach + 1; ++x) sums[row] += static_cast<double>(values[x]);
    }
    const float* before = padded.data();
    const float* after = before + 2 * margin;
    for (std::size_t x = 0; x < columns; ++x) {
        for (std::size_t row = 0; row < kCount; ++row) {
            const std::size_t at = row * stride + x;
            const double ends = static_cast<double>(before[at]) + static_cast<double>(after[at]);
            rows[row * columns + x] = static_cast<float>(box.weight * (sums[row] + box.end * ends));
            sums[row] += static_cast<double>(after[at]) - static_cast<double>(before[at + 1]);
        }
    }
}

}  // namespace

void blur(std::vector<float>& values, int width, int height, double sigma, std::vector<float>& scratch,
          Executor& executor) {
    assert(sigma >= 0 && values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const Box down = box_of(sigma, height), across = box_of(sigma, width);
    const auto columns = static_cast<std::size_t>(width);
    scratch.resize(values.size());
    for_ranges(executor, columns, kColumns, [&](std::size_t begin, std::size_t end) {
        filter_columns(down, width, height, values.data() + begin, scratch.data() + begin, end - begin);
        filter_columns(down, width, height, scratch.data() + begin, values.data() + begin, end - begin);
    });
    for_ranges(executor, static_cast<std::size_t>(height), rows_of_task(width),
               [&](std::size_t begin, std::size_t end) {
                   std::vector<float> padded;
                   for (std::size_t row = begin; row < end;) {
                       const bool single = end - row < kRows;
                       const auto filter = single ? filter_rows<1> : filter_rows<kRows>;
                       for (int i = 0; i < kBoxes; ++i) filter(across, width, values.data() + row * columns, padded);
                       row += single ? 1 : kRows;
                   }
               });
}

std::vector<float> blurred(std::vector<float> values, int width, int height, double sigma, Executor& executor) {
    std::vector<float> scratch;
    blur(values, width, height, sigma, scratch, executor);
    return values;
}

}  // namespace ccdt
