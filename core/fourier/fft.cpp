#include "core/fourier/fft.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>
#include <mutex>
#include <new>
#include <optional>

#include <fftw3.h>

namespace ccdt {
namespace {

/// Measured plans would depend on the clock, vector instructions on the processor.
constexpr unsigned kFlags = FFTW_ESTIMATE | FFTW_NO_SIMD | FFTW_UNALIGNED;

/// FFTW's planner keeps state of its own and is not safe to share; running a plan is.
std::mutex& planner() {
    static std::mutex mutex;
    return mutex;
}

struct Free {
    void operator()(void* memory) const { fftw_free(memory); }
};

/// Memory as FFTW aligns it, so that no plan depends on where it happens to lie.
template <class T>
class Buffer {
public:
    explicit Buffer(std::size_t size) : size_(size) { restore(); }

    void release() { data_.reset(); }

    /// Brings released memory again, all 0.
    void restore() {
        if (data_) return;
        data_.reset(static_cast<T*>(fftw_malloc(size_ * sizeof(T))));
        if (!data_) throw std::bad_alloc();
        std::uninitialized_fill_n(data_.get(), size_, T());
    }

    T* data() const { return data_.get(); }
    std::span<T> view() const { return {data_.get(), size_}; }

private:
    std::size_t size_;
    std::unique_ptr<T[], Free> data_;
};

class Plan {
public:
    /// @param make  calls one of FFTW's planners
    template <class Make>
    explicit Plan(Make make) {
        const std::lock_guard lock(planner());
        plan_ = make();
        if (plan_ == nullptr) throw std::bad_alloc();
    }
    Plan(const Plan&) = delete;
    Plan& operator=(const Plan&) = delete;
    ~Plan() {
        const std::lock_guard lock(planner());
        fftw_destroy_plan(plan_);
    }

    fftw_plan get() const { return plan_; }

private:
    fftw_plan plan_ = nullptr;
};

std::size_t product(int columns, int rows) {
    assert(columns >= 1 && rows >= 1);
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
}

/// std::complex is laid out as FFTW's pair of doubles: the C++ standard says so.
fftw_complex* pairs(std::complex<double>* values) {
    return reinterpret_cast<fftw_complex*>(values);
}

/// Transforms of all rows of a grid, or of all columns: some at a time, each time at the same time as others.
class Lines {
public:
    static constexpr int kLines = 16;

    /// @param make  calls one of FFTW's planners for so many lines
    template <class Make>
    Lines(int count, Make make) : count_(count) {
        if (count >= kLines) some_.emplace([&] { return make(kLines); });
        if (count % kLines != 0) rest_.emplace([&] { return make(count % kLines); });
    }

    /// @param execute  called with a plan, and the number of its first line and the one after its last
    template <class Execute>
    void run(Team& team, Execute execute) const {
        for_ranges(team, static_cast<std::size_t>(count_), kLines, [&](std::size_t begin, std::size_t end) {
            execute((end - begin == kLines ? some_ : rest_)->get(), begin, end);
        });
    }

private:
    int count_;
    std::optional<Plan> some_, rest_;
};

/// From a column to the next one, apart from where they lie in a grid: where rows are a power of two in number, all
/// columns at once would else meet in few places of the cache.
std::size_t column_stride(std::size_t rows) {
    constexpr std::size_t kLine = 8;  // values
    return rows + kLine;
}

/// Transforms columns where they lie next to each other: in a large grid their steps from row to row would meet in few
/// places of the cache.
/// @param grid     row by row
/// @param execute  called with a plan and columns one after the other
template <class Value, class Execute>
void run_columns(Team& team, const Lines& lines, Value* grid, std::size_t width, std::size_t rows, Execute execute) {
    lines.run(team, [&](fftw_plan plan, std::size_t begin, std::size_t end) {
        const std::size_t stride = column_stride(rows);
        const Buffer<Value> columns((end - begin) * stride);
        Value* const data = columns.data();
        for (std::size_t row = 0; row < rows; ++row) {
            for (std::size_t i = begin; i < end; ++i) data[(i - begin) * stride + row] = grid[row * width + i];
        }
        execute(plan, data);
        for (std::size_t row = 0; row < rows; ++row) {
            for (std::size_t i = begin; i < end; ++i) grid[row * width + i] = data[(i - begin) * stride + row];
        }
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

struct RealTransform::Plans {
    Plans(int columns, int rows, Team& of_threads, std::size_t spare_size)
        : team(of_threads),
          width(static_cast<std::size_t>(columns)),
          height(static_cast<std::size_t>(rows)),
          kept(width / 2 + 1),
          spare(spare_size),
          grid(product(columns, rows)),
          spectrum(std::max(kept * height, (spare + 1) / 2)),
          rows_forward(rows,
                       [&](int lines) {
                           return fftw_plan_many_dft_r2c(1, &columns, lines, grid.data(), nullptr, 1, columns,
                                                         pairs(spectrum.data()), nullptr, 1, columns / 2 + 1, kFlags);
                       }),
          rows_backward(rows,
                        [&](int lines) {
                            return fftw_plan_many_dft_c2r(1, &columns, lines, pairs(spectrum.data()), nullptr, 1,
                                                          columns / 2 + 1, grid.data(), nullptr, 1, columns, kFlags);
                        }),
          columns_forward(columns / 2 + 1, [&](int lines) { return plan_columns(rows, lines, FFTW_FORWARD); }),
          columns_backward(columns / 2 + 1, [&](int lines) { return plan_columns(rows, lines, FFTW_BACKWARD); }) {}

    static fftw_plan plan_columns(int rows, int lines, int sign) {
        const auto stride = static_cast<int>(column_stride(static_cast<std::size_t>(rows)));
        const Buffer<std::complex<double>> buffer(product(stride, lines));
        fftw_complex* const data = pairs(buffer.data());
        return fftw_plan_many_dft(1, &rows, lines, data, nullptr, 1, stride, data, nullptr, 1, stride, sign, kFlags);
    }

    void restore() {
        grid.restore();
        spectrum.restore();
    }

    void transform_columns(const Lines& lines) {
        run_columns(team, lines, spectrum.data(), kept, height, [](fftw_plan plan, std::complex<double>* data) {
            fftw_execute_dft(plan, pairs(data), pairs(data));
        });
    }

    Team& team;
    std::size_t width, height, kept, spare;
    Buffer<double> grid;
    Buffer<std::complex<double>> spectrum;  ///< [kept * height], or what is spare
    Lines rows_forward, rows_backward, columns_forward, columns_backward;
};

RealTransform::RealTransform(int columns, int rows, Team& team, std::size_t spare)
    : plans_(std::make_unique<Plans>(columns, rows, team, spare)) {}
RealTransform::RealTransform(RealTransform&&) noexcept = default;
RealTransform& RealTransform::operator=(RealTransform&&) noexcept = default;
RealTransform::~RealTransform() = default;

void RealTransform::rest() {
    plans_->grid.release();
    plans_->spectrum.release();
}

std::span<double> RealTransform::grid() {
    plans_->restore();
    return plans_->grid.view();
}

std::span<std::complex<double>> RealTransform::spectrum() {
    return plans_->spectrum.view().first(plans_->kept * plans_->height);
}

std::span<const std::complex<double>> RealTransform::spectrum() const {
    return plans_->spectrum.view().first(plans_->kept * plans_->height);
}

std::span<double> RealTransform::spare() {
    plans_->restore();
    return {reinterpret_cast<double*>(plans_->spectrum.data()), plans_->spare};
}

void RealTransform::forward() {
    Plans& p = *plans_;
    p.rows_forward.run(p.team, [&](fftw_plan plan, std::size_t row, std::size_t) {
        fftw_execute_dft_r2c(plan, p.grid.data() + row * p.width, pairs(p.spectrum.data() + row * p.kept));
    });
    p.transform_columns(p.columns_forward);
}

void RealTransform::backward() {
    Plans& p = *plans_;
    p.transform_columns(p.columns_backward);
    p.rows_backward.run(p.team, [&](fftw_plan plan, std::size_t row, std::size_t) {
        fftw_execute_dft_c2r(plan, pairs(p.spectrum.data() + row * p.kept), p.grid.data() + row * p.width);
    });
}

struct CosineTransform::Plans {
    Plans(int columns, int rows, Team& of_threads, std::size_t spare)
        : team(of_threads),
          width(static_cast<std::size_t>(columns)),
          height(static_cast<std::size_t>(rows)),
          grid(std::max(width * height, spare)),
          rows_forward(rows, [&](int lines) { return plan(columns, lines, width, FFTW_REDFT10); }),
          rows_backward(rows, [&](int lines) { return plan(columns, lines, width, FFTW_REDFT01); }),
          columns_forward(columns, [&](int lines) { return plan(rows, lines, column_stride(height), FFTW_REDFT10); }),
          columns_backward(columns, [&](int lines) { return plan(rows, lines, column_stride(height), FFTW_REDFT01); }) {
    }

    static fftw_plan plan(int size, int lines, std::size_t from_line_to_line, fftw_r2r_kind kind) {
        const auto stride = static_cast<int>(from_line_to_line);
        const Buffer<double> buffer(product(stride, lines));
        return fftw_plan_many_r2r(1, &size, lines, buffer.data(), nullptr, 1, stride, buffer.data(), nullptr, 1, stride,
                                  &kind, kFlags);
    }

    void transform_rows(const Lines& lines) {
        lines.run(team, [this](fftw_plan plan, std::size_t row, std::size_t) {
            fftw_execute_r2r(plan, grid.data() + row * width, grid.data() + row * width);
        });
    }

    void transform_columns(const Lines& lines) {
        run_columns(team, lines, grid.data(), width, height,
                    [](fftw_plan plan, double* data) { fftw_execute_r2r(plan, data, data); });
    }

    Team& team;
    std::size_t width, height;
    Buffer<double> grid;  ///< [width * height], and what is spare
    Lines rows_forward, rows_backward, columns_forward, columns_backward;
};

CosineTransform::CosineTransform(int columns, int rows, Team& team, std::size_t spare)
    : plans_(std::make_unique<Plans>(columns, rows, team, spare)) {}
CosineTransform::CosineTransform(CosineTransform&&) noexcept = default;
CosineTransform& CosineTransform::operator=(CosineTransform&&) noexcept = default;
CosineTransform::~CosineTransform() = default;

void CosineTransform::rest() {
    plans_->grid.release();
}

std::span<double> CosineTransform::grid() {
    return spare().first(plans_->width * plans_->height);
}

std::span<double> CosineTransform::spare() {
    plans_->grid.restore();
    return plans_->grid.view();
}

void CosineTransform::forward() {
    plans_->transform_rows(plans_->rows_forward);
    plans_->transform_columns(plans_->columns_forward);
}

void CosineTransform::backward() {
    plans_->transform_columns(plans_->columns_backward);
    plans_->transform_rows(plans_->rows_backward);
}

}  // namespace ccdt
