#include "core/fourier/fft.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>
#include <mutex>
#include <new>

#include <fftw3.h>

namespace ccdt {
namespace {

/// Measured plans would depend on the clock, vector instructions on the processor.
constexpr unsigned kFlags = FFTW_ESTIMATE | FFTW_NO_SIMD;

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
    explicit Buffer(std::size_t size) : data_(static_cast<T*>(fftw_malloc(size * sizeof(T)))), size_(size) {
        if (!data_) throw std::bad_alloc();
        std::uninitialized_fill_n(data_.get(), size, T());
    }

    T* data() const { return data_.get(); }
    std::span<T> view() const { return {data_.get(), size_}; }

private:
    std::unique_ptr<T[], Free> data_;
    std::size_t size_;
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

    void run() const { fftw_execute(plan_); }

private:
    fftw_plan plan_ = nullptr;
};

std::size_t product(int columns, int rows) {
    assert(columns >= 1 && rows >= 1);
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
}

/// std::complex is laid out as FFTW's pair of doubles: the C++ standard says so.
fftw_complex* pairs(const Buffer<std::complex<double>>& buffer) {
    return reinterpret_cast<fftw_complex*>(buffer.data());
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
    Plans(int columns, int rows)
        : grid(product(columns, rows)),
          spectrum(product(columns / 2 + 1, rows)),
          forward([&] { return fftw_plan_dft_r2c_2d(rows, columns, grid.data(), pairs(spectrum), kFlags); }),
          backward([&] { return fftw_plan_dft_c2r_2d(rows, columns, pairs(spectrum), grid.data(), kFlags); }) {}

    Buffer<double> grid;
    Buffer<std::complex<double>> spectrum;
    Plan forward;
    Plan backward;
};

RealTransform::RealTransform(int columns, int rows) : plans_(std::make_unique<Plans>(columns, rows)) {}
RealTransform::RealTransform(RealTransform&&) noexcept = default;
RealTransform& RealTransform::operator=(RealTransform&&) noexcept = default;
RealTransform::~RealTransform() = default;

std::span<double> RealTransform::grid() {
    return plans_->grid.view();
}

std::span<std::complex<double>> RealTransform::spectrum() {
    return plans_->spectrum.view();
}

std::span<const std::complex<double>> RealTransform::spectrum() const {
    return plans_->spectrum.view();
}

void RealTransform::forward() {
    plans_->forward.run();
}

void RealTransform::backward() {
    plans_->backward.run();
}

struct CosineTransform::Plans {
    Plans(int columns, int rows)
        : grid(product(columns, rows)),
          forward(plan(grid, columns, rows, FFTW_REDFT10)),
          backward(plan(grid, columns, rows, FFTW_REDFT01)) {}

    static Plan plan(const Buffer<double>& grid, int columns, int rows, fftw_r2r_kind kind) {
        return Plan([&] { return fftw_plan_r2r_2d(rows, columns, grid.data(), grid.data(), kind, kind, kFlags); });
    }

    Buffer<double> grid;
    Plan forward;
    Plan backward;
};

CosineTransform::CosineTransform(int columns, int rows) : plans_(std::make_unique<Plans>(columns, rows)) {}
CosineTransform::CosineTransform(CosineTransform&&) noexcept = default;
CosineTransform& CosineTransform::operator=(CosineTransform&&) noexcept = default;
CosineTransform::~CosineTransform() = default;

std::span<double> CosineTransform::grid() {
    return plans_->grid.view();
}

void CosineTransform::forward() {
    plans_->forward.run();
}

void CosineTransform::backward() {
    plans_->backward.run();
}

}  // namespace ccdt
