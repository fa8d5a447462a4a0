// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/wave_grid.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "core/ccdt/polish/semicircle_kernel.h"
#include "core/ccdt/polish/spline_kernel.h"

namespace ccdt {

namespace {

template <class P>
using Kernel = std::conditional_t<kAxes<P> == 2, SplineKernel, SemicircleKernel>;

std::variant<RealTransform, CosineTransform> make_transform(bool torus, const std::array<int, 3>& cells,
                                                            Executor& executor, std::size_t padded) {
    if (torus) return RealTransform(cells, executor, padded);
    return CosineTransform(cells, executor, padded);
}

}  // namespace

template <class P>
BasicWaveGrid<P>::BasicWaveGrid(bool torus, P sides, const std::array<int, 3>& cells, Executor& executor)
    : executor_(executor),
      frame_{torus, sides, cells},
      transform_(make_transform(torus, cells, executor, frame_.padded_lines() * frame_.padded(0))) {
    acquire_memory();
    for (std::size_t axis = 0; axis < kAxes<P>; ++axis) {
        assert(along(sides, axis) > 0);
        const int kept = torus && axis == 0 ? cells[0] / 2 + 1 : cells[axis];
        for (int i = 0; i < kept; ++i) windows_[axis].push_back(Kernel<P>::window(frame_.periods() * i, cells[axis]));
    }
}

template <class P>
void BasicWaveGrid<P>::clear() {
    acquire_memory();
    constexpr std::size_t kRange = 65536;
    for_ranges(executor_, padded_.size(), kRange, [&](std::size_t begin, std::size_t end) {
        std::ranges::fill(padded_.subspan(begin, end - begin), 0.0);
    });
}

/// Calls add(numbers) with the indices of points, in groups. Leaves out points for which counts(index) is false. The
/// rows of a grid in the plane, or the layers of one in space, are divided into bands. First the even bands are
/// processed in parallel, then the odd bands: taps reach no further than the next band.
template <class P>
template <class Counts, class Add>
void BasicWaveGrid<P>::add_all(std::span<const P> points, Counts&& counts, Add&& add) {
    // With fewer points, sorting costs more than it gains. This number is also the size of a task.
    constexpr std::size_t kPointsPerTask = Kernel<P>::kPointsPerTask;
    std::vector<std::uint32_t> order;
    if (points.size() <= kPointsPerTask) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (counts(i)) order.push_back(static_cast<std::uint32_t>(i));
        }
        return add(order);
    }
    constexpr std::size_t kMaxBands = 512;  // bounds the memory for long grids
    const std::size_t layers = frame_.padded(kAxes<P> - 1);
    const std::size_t height = std::max(Kernel<P>::kBand, layers / kMaxBands + 1);
    const std::size_t bands = layers / height + 1;
    const std::size_t parts = (points.size() + kPointsPerTask - 1) / kPointsPerTask;
    const Kernel<P> kernel(frame_, padded_.data());
    const auto band_of = [&](std::size_t i) { return kernel.first_layer(points[i]) / height; };
    // [parts][bands] position in the order for the next point of each band in a part.
    std::vector<std::uint32_t> next(parts * bands, 0);
    for_ranges(executor_, points.size(), kPointsPerTask, [&](std::size_t begin, std::size_t end) {
        std::uint32_t* const count = &next[begin / kPointsPerTask * bands];
        for (std::size_t i = begin; i < end; ++i) {
            if (counts(i)) ++count[band_of(i)];
        }
    });
    std::vector<std::uint32_t> begins{0};  // [bands + 1] start of each band
    for (std::size_t band = 0; band < bands; ++band) {
        std::uint32_t begin = begins.back();
        for (std::size_t part = 0; part < parts; ++part) begin += std::exchange(next[part * bands + band], begin);
        begins.push_back(begin);
    }
    order.resize(begins.back());
    for_ranges(executor_, points.size(), kPointsPerTask, [&](std::size_t begin, std::size_t end) {
        std::uint32_t* const next_of = &next[begin / kPointsPerTask * bands];
        for (std::size_t i = begin; i < end; ++i) {
            if (counts(i)) order[next_of[band_of(i)]++] = static_cast<std::uint32_t>(i);
        }
    });
    for (std::size_t odd = 0; odd < 2; ++odd) {
        executor_.run((bands + 1 - odd) / 2, [&](std::size_t number) {
            const std::size_t band = 2 * number + odd;
            add(std::span(order).subspan(begins[band], begins[band + 1] - begins[band]));
        });
    }
}

template <class P>
void BasicWaveGrid<P>::spread(std::span<const P> points, std::span<const double> values) {
    const Kernel<P> kernel(frame_, padded_.data());
    const auto counts = [&](std::size_t i) { return values.empty() || values[i] != 0; };
    add_all(points, counts, [&](std::span<const std::uint32_t> numbers) { kernel.spread(points, values, numbers); });
}

template <class P>
void BasicWaveGrid<P>::spread_moves(std::span<const P> points, std::span<const P> moves) {
    if constexpr (kAxes<P> == 2) {
        const Kernel<P> kernel(frame_, padded_.data());
        const auto each = [](std::size_t) { return true; };
        add_all(points, each, [&](std::span<const std::uint32_t> numbers) {
            for (const std::uint32_t i : numbers) kernel.spread_move(points[i], moves[i]);
        });
    }
}

template <class P>
void BasicWaveGrid<P>::gradients(std::span<const P> points, std::span<P> gradients) const {
    Kernel<P>(frame_, padded_.data()).gradients(points, gradients);
}

/// Calls visit(index in a padded line, index of the cell repeated there) for all margin cells of a line.
template <class P>
template <class Visit>
void BasicWaveGrid<P>::for_margins(Visit&& visit) const {
    for (std::size_t i = 0; i < frame_.margin(0); ++i) {
        for (const std::size_t cell : {i, frame_.margin(0) + frame_.width() + i}) visit(cell, frame_.folded(cell, 0));
    }
}

/// Calls visit(margin line, line repeated there) for all margin lines.
template <class P>
template <class Visit>
void BasicWaveGrid<P>::for_margin_lines(Visit&& visit) {
    const std::size_t rows = frame_.padded(1), size = frame_.padded(0);
    for (std::size_t line = 0; line < frame_.padded_lines(); ++line) {
        const std::size_t inside = frame_.folded(line / rows, 2) * rows + frame_.folded(line % rows, 1);
        if (inside != line) visit(&padded_[line * size], &padded_[inside * size]);
    }
}

/// Adds the values in the margins to the cells that the margins repeat, and moves the sums to the grid.
template <class P>
void BasicWaveGrid<P>::fold() {
    const std::size_t width = frame_.width(), margin = frame_.margin(0);
    const auto padded = [&](std::size_t line) { return &padded_[frame_.padded_line(line) * frame_.padded(0)]; };
    for_ranges(executor_, frame_.lines(), kLines, [&](std::size_t begin, std::size_t end) {
        for (std::size_t line = begin; line < end; ++line)
            for_margins([own = padded(line)](std::size_t i, std::size_t inside) { own[inside] += own[i]; });
    });
    for_margin_lines([&](const double* line, double* inside) {
        for_margins([&](std::size_t i, std::size_t to) { inside[to] += line[i]; });
        for (std::size_t i = margin; i < margin + width; ++i) inside[i] += line[i];
    });
    // In a box, the cells overlap the padded lines: a line may be moved only after the lines before it.
    Executor& executor = frame_.torus ? executor_ : inline_executor();
    for_ranges(executor, frame_.lines(), kLines, [&, cells = grid().data()](std::size_t begin, std::size_t end) {
        for (std::size_t line = begin; line < end; ++line)
            std::copy_n(padded(line) + margin, width, cells + line * width);
    });
}

/// Moves the grid's values to the padded lines, and fills the margins by periodic or mirrored repetition.
template <class P>
void BasicWaveGrid<P>::unfold() {
    const std::size_t width = frame_.width();
    const auto padded = [&](std::size_t line) { return &padded_[frame_.padded_line(line) * frame_.padded(0)]; };
    const auto move = [&, cells = grid().data()](std::size_t line) {
        const double* const end = cells + (line + 1) * width;
        std::copy_backward(end - width, end, padded(line) + frame_.margin(0) + width);
    };
    for (std::size_t line = frame_.torus ? 0 : frame_.lines(); line-- > 0;) move(line);  // they overlap, as in fold()
    for_ranges(executor_, frame_.lines(), kLines, [&](std::size_t begin, std::size_t end) {
        for (std::size_t line = begin; line < end; ++line) {
            if (frame_.torus) move(line);
            for_margins([own = padded(line)](std::size_t i, std::size_t inside) { own[i] = own[inside]; });
        }
    });
    for_margin_lines([&](double* line, const double* inside) { std::copy_n(inside, frame_.padded(0), line); });
}

template class BasicWaveGrid<Point>;
template class BasicWaveGrid<Point3>;

}  // namespace ccdt
