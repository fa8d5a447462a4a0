// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/fft.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdlib>
#include <limits>
#include <new>

#include "core/base/line_transforms.h"

namespace ccdt {
namespace {

/// Number of lines per task. Vector instructions process fewer lines at once. In a row, the numbers of this many
/// columns fill whole cache lines.
constexpr std::size_t kLines = 16;

struct Free {
    void operator()(void* memory) const { std::free(memory); }
};

template <class T>
using Memory = std::unique_ptr<T[], Free>;

template <class T>
Memory<T> taken(void* memory) {
    if (memory == nullptr) throw std::bad_alloc();
    return Memory<T>(static_cast<T*>(memory));
}

/// An array of numbers whose memory can be released temporarily.
template <class T>
class Buffer {
public:
    explicit Buffer(std::size_t size) : size_(size) { restore(); }

    void release() { data_.reset(); }

    /// Allocates released memory again, all 0.
    void restore() {
        if (!data_) data_ = taken<T>(std::calloc(size_, sizeof(T)));
    }

    T* data() const { return data_.get(); }
    std::span<T> view() const { return {data_.get(), size_}; }

private:
    std::size_t size_;
    Memory<T> data_;
};

/// Size of a grid. A grid in the plane has one layer.
struct GridSize {
    explicit GridSize(const std::array<int, 3>& cells)
        : width(static_cast<std::size_t>(cells[0])),
          height(static_cast<std::size_t>(cells[1])),
          layers(static_cast<std::size_t>(cells[2])) {
        assert(cells[0] >= 1 && cells[1] >= 1 && cells[2] >= 1);
    }

    std::size_t rows() const { return height * layers; }

    std::size_t width, height, layers;
};

/// Copies a few columns at a time and transforms the copies. In place, the numbers of a column would be a large stride
/// apart, and so share few sets of the cache.
/// @param grid       row by row
/// @param transform  called with the lines and a pointer to the first line
template <class Value, class Transform>
void for_columns(Executor& executor, Value* grid, std::size_t width, std::size_t rows, Transform&& transform) {
    for_ranges(executor, width, kLines, [&](std::size_t begin, std::size_t end) {
        const std::size_t count = end - begin;
        const auto columns = taken<Value>(std::malloc(count * rows * sizeof(Value)));
        for (std::size_t row = 0; row < rows; ++row)
            std::copy_n(grid + row * width + begin, count, columns.get() + row * count);
        transform(LineSet{rows, count, count, 1}, columns.get());
        for (std::size_t row = 0; row < rows; ++row)
            std::copy_n(columns.get() + row * count, count, grid + row * width + begin);
    });
}

/// Transforms the columns of each layer, then the lines across the layers.
template <class Value, class Transform>
void for_columns_and_lines(Executor& executor, Value* grid, std::size_t width, const GridSize& size,
                           Transform&& transform) {
    if (size.layers == 1) return for_columns(executor, grid, width, size.height, transform);
    executor.run(size.layers, [&](std::size_t layer) {
        for_columns(inline_executor(), grid + layer * width * size.height, width, size.height, transform);
    });
    for_columns(executor, grid, width * size.height, size.layers, transform);
}

/// Calls transform(rows, number of the first row) for a few rows at a time.
template <class Transform>
void for_rows(Executor& executor, std::size_t width, std::size_t rows, Transform&& transform) {
    for_ranges(executor, rows, kLines, [&](std::size_t begin, std::size_t end) {
        transform(LineSet{width, 1, end - begin, width}, begin);
    });
}

}  // namespace

int good_size(double least) {
    assert(least <= 1e9);
    auto best = std::numeric_limits<long long>::max();
    for (long long fives = 2; fives < best; fives *= 5) {
        for (long long threes = fives; threes < best; threes *= 3) {
            long long size = threes;
            while (static_cast<double>(size) < least) size *= 2;
            best = std::min(best, size);
        }
    }
    return static_cast<int>(best);
}

struct RealTransform::Grids {
    Grids(const std::array<int, 3>& cells, Executor& of_threads, std::size_t spare_size)
        : executor(of_threads),
          size(cells),
          kept(size.width / 2 + 1),
          spare(spare_size),
          grid(size.width * size.rows()),
          spectrum(std::max(kept * size.rows(), (spare + 1) / 2)) {}

    std::span<std::complex<double>> coefficients() { return spectrum.view().first(kept * size.rows()); }

    void restore() {
        grid.restore();
        spectrum.restore();
    }

    Executor& executor;
    GridSize size;
    std::size_t kept, spare;
    Buffer<double> grid;
    Buffer<std::complex<double>> spectrum;  ///< [kept * rows], or the spare memory
};

RealTransform::RealTransform(const std::array<int, 3>& cells, Executor& executor, std::size_t spare)
    : grids_(std::make_unique<Grids>(cells, executor, spare)) {}
RealTransform::RealTransform(RealTransform&&) noexcept = default;
RealTransform& RealTransform::operator=(RealTransform&&) noexcept = default;
RealTransform::~RealTransform() = default;

void RealTransform::release_memory() {
    grids_->grid.release();
    grids_->spectrum.release();
}

std::span<double> RealTransform::grid() {
    grids_->restore();
    return grids_->grid.view();
}

std::span<std::complex<double>> RealTransform::spectrum() {
    return grids_->coefficients();
}

std::span<const std::complex<double>> RealTransform::spectrum() const {
    return grids_->coefficients();
}

std::span<double> RealTransform::spare() {
    grids_->restore();
    return {reinterpret_cast<double*>(grids_->spectrum.data()), grids_->spare};
}

void RealTransform::forward() {
    Grids& g = *grids_;
    for_rows(g.executor, g.size.width, g.size.rows(), [&](const LineSet& rows, std::size_t first) {
        line_transforms().real(rows, g.grid.data() + first * g.size.width, g.kept, g.spectrum.data() + first * g.kept);
    });
    for_columns_and_lines(g.executor, g.spectrum.data(), g.kept, g.size, line_transforms().complex);
}

void RealTransform::backward() {
    Grids& g = *grids_;
    for_columns_and_lines(g.executor, g.spectrum.data(), g.kept, g.size, line_transforms().complex_back);
    for_rows(g.executor, g.size.width, g.size.rows(), [&](const LineSet& rows, std::size_t first) {
        line_transforms().real_back(rows, g.grid.data() + first * g.size.width, g.kept,
                                    g.spectrum.data() + first * g.kept);
    });
}

struct CosineTransform::Grids {
    Grids(const std::array<int, 3>& cells, Executor& of_threads, std::size_t spare)
        : executor(of_threads), size(cells), grid(std::max(size.width * size.rows(), spare)) {}

    template <class Transform>
    void transform_rows(Transform&& transform) {
        for_rows(executor, size.width, size.rows(),
                 [&](const LineSet& rows, std::size_t first) { transform(rows, grid.data() + first * size.width); });
    }

    template <class Transform>
    void transform_columns(Transform&& transform) {
        for_columns_and_lines(executor, grid.data(), size.width, size, transform);
    }

    Executor& executor;
    GridSize size;
    Buffer<double> grid;  ///< [width * rows], and the spare memory
};

CosineTransform::CosineTransform(const std::array<int, 3>& cells, Executor& executor, std::size_t spare)
    : grids_(std::make_unique<Grids>(cells, executor, spare)) {}
CosineTransform::CosineTransform(CosineTransform&&) noexcept = default;
CosineTransform& CosineTransform::operator=(CosineTransform&&) noexcept = default;
CosineTransform::~CosineTransform() = default;

void CosineTransform::release_memory() {
    grids_->grid.release();
}

std::span<double> CosineTransform::grid() {
    return spare().first(grids_->size.width * grids_->size.rows());
}

std::span<double> CosineTransform::spare() {
    grids_->grid.restore();
    return grids_->grid.view();
}

void CosineTransform::forward() {
    grids_->transform_rows(line_transforms().cosine);
    grids_->transform_columns(line_transforms().cosine);
}

void CosineTransform::backward() {
    grids_->transform_columns(line_transforms().cosine_back);
    grids_->transform_rows(line_transforms().cosine_back);
}

}  // namespace ccdt
