// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/reduction.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/picture/pixel_ranges.h"
#include "core/picture/tone.h"

namespace ccdt {

namespace {

/// Division of a pixel along one axis between a cell and the next one.
struct Part {
    std::size_t cell = 0;
    double share = 1;  ///< share of the pixel in `cell`; the remaining share is in the next cell
};

/// Returns the division of each pixel along an axis. A pixel lies in at most two cells, because no cell is smaller than
/// a pixel.
std::vector<Part> parts_of(int pixels, int cells) {
    std::vector<Part> parts;
    for (std::int64_t pixel = 0; pixel < pixels; ++pixel) {
        const std::int64_t cell = pixel * cells / pixels;
        const std::int64_t inside = (cell + 1) * pixels - pixel * cells;  // length in units of 1 / cells pixels
        parts.push_back(
            {static_cast<std::size_t>(cell), std::min(1.0, static_cast<double>(inside) / static_cast<double>(cells))});
    }
    return parts;
}

/// Computes means of pixel values over cells.
class CellMeans {
public:
    CellMeans(int width, int height, const CellGrid& cells, Executor& executor)
        : columns_(static_cast<std::size_t>(cells.columns)),
          rows_(static_cast<std::size_t>(cells.rows)),
          across_(parts_of(width, cells.columns)),
          down_(parts_of(height, cells.rows)),
          area_(static_cast<double>(width) * height / (static_cast<double>(cells.columns) * cells.rows)),
          executor_(executor) {}

    /// Writes the mean of value(pixel) over each cell [columns * rows].
    template <class Value>
    void fill(float* to, const Value& value) const {
        const std::size_t rows_of_pixels = (down_.size() + rows_ - 1) / rows_;  // number of pixel rows per row of cells
        const std::size_t range = std::max<std::size_t>(kPixelsOfTask / (across_.size() * rows_of_pixels), 1);
        for_ranges(executor_, rows_, range,
                   [&](std::size_t begin, std::size_t end) { fill_rows(begin, end, to + begin * columns_, value); });
    }

private:
    /// Writes the rows [begin, end) of cells. Keeps sums of two rows, because a row of pixels may lie in both.
    template <class Value>
    void fill_rows(std::size_t begin, std::size_t end, float* to, const Value& value) const {
        std::vector<double> row(columns_ + 1), sums(columns_), next(columns_);
        const auto first = std::ranges::lower_bound(down_, begin, {}, &Part::cell) - down_.begin();
        // The last row of pixels that begins in the row of cells before `begin` may extend into row `begin`.
        for (auto y = static_cast<std::size_t>(std::max<std::ptrdiff_t>(first - 1, 0));
             y < down_.size() && down_[y].cell < end; ++y) {
            add_pixels(y, row, value);
            const double share = down_[y].share;
            for (std::size_t x = 0; x < columns_; ++x) {
                sums[x] += share * row[x];
                next[x] += (1 - share) * row[x];
            }
            const bool is_last = y + 1 == down_.size() || down_[y + 1].cell != down_[y].cell;
            if (!is_last) continue;
            if (down_[y].cell >= begin)
                to = std::ranges::transform(sums, to, [&](double sum) { return static_cast<float>(sum / area_); }).out;
            std::swap(sums, next);
            std::ranges::fill(next, 0.0);
        }
    }

    /// Computes the sum of a row of pixels in each column of cells.
    template <class Value>
    void add_pixels(std::size_t y, std::vector<double>& row, const Value& value) const {
        std::size_t pixel = y * across_.size();
        std::ranges::fill(row, 0.0);
        for (const auto& [cell, share] : across_) {
            const auto each = static_cast<double>(value(pixel++));
            row[cell] += share * each;
            row[cell + 1] += (1 - share) * each;
        }
    }

    std::size_t columns_, rows_;
    std::vector<Part> across_, down_;
    double area_;  ///< area of a cell, in pixels
    Executor& executor_;
};

}  // namespace

CellGrid resolved_cells(int width, int height, double radius) {
    constexpr double kCell = 0.5;   // side of a cell, radii
    constexpr double kMinSide = 2;  // least side of a cell, pixels
    constexpr double kMin = 64;     // least number of cells along the shorter side
    constexpr double kStep = 0.25;  // pixels; sides are multiples of this, so rounding of the radius has no effect
    const double side = kStep * std::floor(std::min(kCell * radius, std::min(width, height) / kMin) / kStep);
    if (!(side >= kMinSide)) return {width, height};
    return {static_cast<int>(std::ceil(width / side)), static_cast<int>(std::ceil(height / side))};
}

std::vector<float> reduced(const std::vector<float>& values, int width, int height, const CellGrid& cells,
                           Executor& executor) {
    assert(cells.columns <= width && cells.rows <= height);
    std::vector<float> means(static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows));
    CellMeans(width, height, cells, executor).fill(means.data(), [&](std::size_t pixel) { return values[pixel]; });
    return means;
}

ColourPicture reduced(const ColourPicture& picture, const CellGrid& cells, Executor& executor) {
    const auto size = static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows);
    const CellMeans all(picture.width, picture.height, cells, executor);
    const auto means = [&](const auto& value) {
        auto plane = std::make_shared_for_overwrite<float[]>(size);
        all.fill(plane.get(), value);
        return plane;
    };
    ColourPicture small{cells.columns, cells.rows, {}, {}, {}, {}};
    std::shared_ptr<float[]> alpha;
    if (!picture.alpha.empty()) alpha = means([&](std::size_t pixel) { return to_share(picture.alpha[pixel]); });
    const auto seen = [&](const Plane& light) {
        if (!alpha) return Plane(means([&](std::size_t pixel) { return to_share(light[pixel]); }), size);
        const auto plane =
            means([&](std::size_t pixel) { return to_share(picture.alpha[pixel]) * to_share(light[pixel]); });
        for (std::size_t i = 0; i < size; ++i) {
            const auto at = static_cast<std::ptrdiff_t>(i);
            plane[at] = alpha[at] > 0 ? plane[at] / alpha[at] : 0;
        }
        return Plane(plane, size);
    };
    small.red = seen(picture.red);
    small.green = seen(picture.green);
    small.blue = seen(picture.blue);
    if (alpha) small.alpha = Plane(alpha, size);
    return small;
}

}  // namespace ccdt
