// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/blur.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "core/base/elementary.h"
#include "core/base/lanes.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

constexpr int kBoxes = 2;

/// Number of columns filtered together, so that their sums stay in the cache.
constexpr std::size_t kColumns = 256;

/// Number of rows filtered together, as columns of their transpose.
constexpr std::size_t kRows = 16;

/// Box filter of 2 * reach + 1 equal weights, and one further weight at each end, smaller by the factor `end`.
struct BoxFilter {
    /// Constructs the filter that has exactly the given variance, in squared pixels.
    explicit BoxFilter(double variance)
        : reach(static_cast<int>((std::sqrt(12 * variance + 1) - 1) / 2)),
          end((2 * reach + 1) * (reach * (reach + 1.0) - 3 * variance) /
              (6 * (variance - (reach + 1.0) * (reach + 1.0)))),
          weight(1 / (2 * reach + 1 + 2 * end)) {}

    int reach;
    double end;
    double weight;
};

BoxFilter box_of(double sigma, int side) {
    const double most = std::min(sigma, 0.5 * side);
    return BoxFilter(most * most / kBoxes);
}

/// Returns the index in [0, side) of the pixel whose mirror image lies at `position`.
int mirrored(int position, int side) {
    if (position >= 0 && position < side) return position;
    const int period = 2 * side;
    const int within = ((position % period) + period) % period;
    return within < side ? within : period - 1 - within;
}

/// Filters some adjacent columns of an image.
/// @param stride    width of the image
/// @param from, to  top of the first column, in the image and in the result
/// @param columns   at most kColumns
CCDT_INLINE inline void filter_columns(const BoxFilter& box, std::size_t stride, int height, const float* from,
                                       float* to, std::size_t columns) {
    const auto row = [&](int y) CCDT_INLINE { return from + static_cast<std::size_t>(mirrored(y, height)) * stride; };
    std::array<double, kColumns> sums{};  // sums of the values within reach
    for (int y = -box.reach; y <= box.reach; ++y) {
        for (std::size_t x = 0; x < columns; ++x) sums[x] += static_cast<double>(row(y)[x]);
    }
    for (int y = 0; y < height; ++y) {
        const float *before = row(y - box.reach - 1), *first = row(y - box.reach), *after = row(y + box.reach + 1);
        float* __restrict out = to + static_cast<std::size_t>(y) * stride;
        for (std::size_t x = 0; x < columns; ++x) {
            const double ends = static_cast<double>(before[x]) + static_cast<double>(after[x]);
            out[x] = static_cast<float>(box.weight * (sums[x] + box.end * ends));
            sums[x] += static_cast<double>(after[x]) - static_cast<double>(first[x]);
        }
    }
}

/// Applies all box filters to some adjacent columns of an image, in place.
/// @param scratch  of the same shape
void blur_columns(const BoxFilter& box, std::size_t stride, int height, float* values, float* scratch,
                  std::size_t columns) {
    static_assert(kBoxes == 2);
    with_lanes([&](auto) CCDT_INLINE {
        filter_columns(box, stride, height, values, scratch, columns);
        filter_columns(box, stride, height, scratch, values, columns);
    });
}

/// Applies all box filters to some rows, in place.
/// @param rows     [count][width], of which there are at most kRows
/// @param scratch  [2][width][kRows]
void blur_rows(const BoxFilter& box, std::size_t width, float* rows, std::size_t count, std::vector<float>& scratch) {
    float* const columns = scratch.data();
    for (std::size_t row = 0; row < count; ++row) {
        for (std::size_t x = 0; x < width; ++x) columns[x * kRows + row] = rows[row * width + x];
    }
    blur_columns(box, kRows, static_cast<int>(width), columns, columns + width * kRows, kRows);
    for (std::size_t row = 0; row < count; ++row) {
        for (std::size_t x = 0; x < width; ++x) rows[row * width + x] = columns[x * kRows + row];
    }
}

/// Returns the weight of a Gaussian at each distance, for each of the two pixels at this distance. The weight at
/// distance 0 is halved, because the middle pixel counts as both.
std::vector<float> gaussian(double sigma) {
    constexpr double kReach = 3;  // standard deviations
    std::vector<double> samples{0.5};
    for (int i = 1; i <= kReach * sigma + 0.5; ++i) samples.push_back(elementary::exp(-0.5 * i * i / (sigma * sigma)));
    const double sum = 2 * std::accumulate(samples.begin(), samples.end(), 0.0);
    std::vector<float> weights(samples.size());
    std::ranges::transform(samples, weights.begin(), [sum](double each) { return static_cast<float>(each / sum); });
    return weights;
}

/// Weighs the values at a distance before and after those of a row, and adds them to sums.
CCDT_INLINE inline void add(float weight, const float* before, const float* after, float* __restrict sums,
                            std::size_t columns) {
    for (std::size_t x = 0; x < columns; ++x) sums[x] += weight * (before[x] + after[x]);
}

}  // namespace

void blur_directly(std::vector<float>& values, int width, int height, double sigma, std::vector<float>& scratch,
                   Executor& executor) {
    const std::vector<float> weights = gaussian(sigma);
    const float* const weight = weights.data();
    const auto columns = static_cast<std::size_t>(width);
    const int reach = static_cast<int>(weights.size()) - 1;
    scratch.resize(values.size());
    const auto row = [&](int y) CCDT_INLINE {
        return values.data() + static_cast<std::size_t>(mirrored(y, height)) * columns;
    };
    // Blurs row y: first down the columns, then across. `down` has `reach` mirrored values before and after the row.
    const auto blur_row = [&](int y, float* down) CCDT_INLINE {
        std::fill_n(down, columns, 0.0f);
        for (int i = 0; i <= reach; ++i) add(weight[i], row(y - i), row(y + i), down, columns);
        for (int i = 1; i <= reach; ++i) {
            down[-i] = down[mirrored(-i, width)];
            down[width + i - 1] = down[mirrored(width + i - 1, width)];
        }
        float* const out = scratch.data() + static_cast<std::size_t>(y) * columns;
        std::fill_n(out, columns, 0.0f);
        for (int i = 0; i <= reach; ++i) add(weight[i], down - i, down + i, out, columns);
    };
    for_ranges(executor, static_cast<std::size_t>(height), rows_of_task(width),
               [&](std::size_t begin, std::size_t end) {
                   std::vector<float> sums(columns + 2 * static_cast<std::size_t>(reach));
                   with_lanes([&](auto) CCDT_INLINE {
                       for (std::size_t y = begin; y < end; ++y) blur_row(static_cast<int>(y), sums.data() + reach);
                   });
               });
    values.swap(scratch);
}

void blur(std::vector<float>& values, int width, int height, double sigma, std::vector<float>& scratch,
          Executor& executor) {
    assert(sigma >= 0 && values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const BoxFilter down = box_of(sigma, height), across = box_of(sigma, width);
    const auto columns = static_cast<std::size_t>(width);
    scratch.resize(values.size());
    for_ranges(executor, columns, kColumns, [&](std::size_t begin, std::size_t end) {
        blur_columns(down, columns, height, values.data() + begin, scratch.data() + begin, end - begin);
    });
    for_ranges(
        executor, static_cast<std::size_t>(height), rows_of_task(width), [&](std::size_t begin, std::size_t end) {
            std::vector<float> transposed(2 * columns * kRows);
            for (std::size_t row = begin; row < end; row += kRows)
                blur_rows(across, columns, values.data() + row * columns, std::min(kRows, end - row), transposed);
        });
}

std::vector<float> blurred(std::vector<float> values, int width, int height, double sigma, Executor& executor) {
    std::vector<float> scratch;
    blur(values, width, height, sigma, scratch, executor);
    return values;
}

}  // namespace ccdt
