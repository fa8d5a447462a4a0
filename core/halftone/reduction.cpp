#include "core/halftone/reduction.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/halftone/tone.h"

namespace ccdt {

namespace {

/// Where a pixel goes along one side: a share of it into one cell, the rest into the next.
struct Part {
    std::size_t cell = 0;
    double share = 1;
};

/// Parts of all pixels along a side. No cell is smaller than a pixel, so that none lies in more than two.
std::vector<Part> parts_of(int pixels, int cells) {
    std::vector<Part> parts;
    for (std::int64_t pixel = 0; pixel < pixels; ++pixel) {
        const std::int64_t cell = pixel * cells / pixels;
        const std::int64_t inside = (cell + 1) * pixels - pixel * cells;  // in a pixel's parts, of which it has `cells`
        parts.push_back(
            {static_cast<std::size_t>(cell), std::min(1.0, static_cast<double>(inside) / static_cast<double>(cells))});
    }
    return parts;
}

/// Sums of rows of cells, of which two are being filled.
class CellRows {
public:
    CellRows(int width, int height, const CellGrid& cells)
        : columns_(static_cast<std::size_t>(cells.columns)),
          across_(parts_of(width, cells.columns)),
          down_(parts_of(height, cells.rows)),
          area_(static_cast<double>(width) * height / (static_cast<double>(cells.columns) * cells.rows)),
          row_(columns_ + 1),
          sums_(columns_),
          next_(columns_) {}

    /// Fills [columns * rows] with means of values, which are told by their pixel.
    template <class Value>
    void fill(float* to, const Value& value) {
        std::size_t pixel = 0;
        std::ranges::fill(sums_, 0.0);
        std::ranges::fill(next_, 0.0);
        for (std::size_t y = 0; y < down_.size(); ++y) {
            std::ranges::fill(row_, 0.0);
            for (const auto& [cell, share] : across_) {
                const auto each = static_cast<double>(value(pixel++));
                row_[cell] += share * each;
                row_[cell + 1] += (1 - share) * each;
            }
            const double share = down_[y].share;
            for (std::size_t x = 0; x < columns_; ++x) {
                sums_[x] += share * row_[x];
                next_[x] += (1 - share) * row_[x];
            }
            const bool is_last = y + 1 == down_.size() || down_[y + 1].cell != down_[y].cell;
            if (is_last) to = finish_row(to);
        }
    }

private:
    float* finish_row(float* to) {
        to = std::ranges::transform(sums_, to, [&](double sum) { return static_cast<float>(sum / area_); }).out;
        std::swap(sums_, next_);
        std::ranges::fill(next_, 0.0);
        return to;
    }

    std::size_t columns_;
    std::vector<Part> across_, down_;
    double area_;  ///< of a cell, in pixels
    std::vector<double> row_;
    std::vector<double> sums_, next_;  ///< of the cells' rows that a pixel's row may lie in
};

}  // namespace

CellGrid resolved_cells(int width, int height, double radius) {
    constexpr double kCell = 0.5;  // radii
    constexpr double kLeast = 2;   // pixels
    constexpr double kFewest = 64;
    constexpr double kStep = 0.25;  // pixels: radii that are the same but for rounding have the same cells
    const double side = kStep * std::floor(std::min(kCell * radius, std::min(width, height) / kFewest) / kStep);
    if (!(side >= kLeast)) return {width, height};
    return {static_cast<int>(std::ceil(width / side)), static_cast<int>(std::ceil(height / side))};
}

std::vector<float> reduced(const std::vector<float>& values, int width, int height, const CellGrid& cells) {
    assert(cells.columns <= width && cells.rows <= height);
    std::vector<float> means(static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows));
    CellRows(width, height, cells).fill(means.data(), [&](std::size_t pixel) { return values[pixel]; });
    return means;
}

ColourPicture reduced(const ColourPicture& picture, const CellGrid& cells) {
    const auto size = static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows);
    CellRows rows(picture.width, picture.height, cells);
    const auto means = [&](const auto& value) {
        const auto plane = std::make_shared_for_overwrite<float[]>(size);
        rows.fill(plane.get(), value);
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
