// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/polish/spline_grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "core/geometry/lanes.h"
#include "core/geometry/spreading.h"

namespace ccdt {

namespace {

constexpr int kDegree = 5;
constexpr std::size_t kTaps = kDegree + 1;
constexpr std::size_t kMargin = 3;  ///< number of cells beyond the grid that taps can reach

/// Values of the B-spline at the six grid points around a position, along both axes. Each value is a vector with a pair
/// (x, y) for each of the points that are processed together.
template <class Pairs>
using Taps = std::array<Pairs, kTaps>;

/// Returns the slopes of the quintic B-spline at the six grid points around a position.
template <class Pairs>
CCDT_INLINE inline Taps<Pairs> slopes_at(Pairs f) {
    const auto outer = [](Pairs d) CCDT_INLINE {
        const Pairs g = 1.0 - d, g2 = g * g;
        return g2 * g2 * (-1.0 / 24);
    };
    const auto inner = [](Pairs d) CCDT_INLINE {
        const Pairs x = 1.0 + d;
        return 5.0 / 8 + x * (-7.0 / 2 + x * (15.0 / 4 + x * (-3.0 / 2 + x * (5.0 / 24))));
    };
    const auto middle = [](Pairs d) CCDT_INLINE { return d * (-1.0 + d * d * (1.0 - d * (5.0 / 12))); };
    const Pairs g = 1.0 - f;
    return {outer(f), inner(f), middle(f), -middle(g), -inner(g), -outer(g)};
}

/// The six successive values that the taps of a point cover in a row.
template <class Lanes>
struct Row {
    typename Lanes::Pairs low{};
    std::array<Pair, kTaps / 2 - Lanes::kCount> high{};

    CCDT_INLINE static Row of(const std::array<Pair, kTaps / 2>& pairs) {
        Row row;
        std::array<Pair, Lanes::kCount> low;
        std::copy_n(pairs.begin(), low.size(), low.begin());
        row.low = Lanes::join(low);
        std::copy_n(pairs.begin() + low.size(), row.high.size(), row.high.begin());
        return row;
    }
    CCDT_INLINE std::array<Pair, kTaps / 2> pairs() const {
        std::array<Pair, kTaps / 2> pairs;
        for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) pairs[lane] = Lanes::pair(low, lane);
        std::copy_n(high.begin(), high.size(), pairs.begin() + Lanes::kCount);
        return pairs;
    }
    CCDT_INLINE static Row load(const double* values) {
        Row row;
        std::memcpy(&row.low, values, sizeof row.low);
        std::memcpy(row.high.data(), values + 2 * Lanes::kCount, sizeof row.high);
        return row;
    }
    CCDT_INLINE void store(double* values) const {
        std::memcpy(values, &low, sizeof low);
        std::memcpy(values + 2 * Lanes::kCount, high.data(), sizeof high);
    }
    CCDT_INLINE void add(double factor, const Row& row) {
        low += factor * row.low;
        for (std::size_t i = 0; i < high.size(); ++i) high[i] += factor * row.high[i];
    }
};

/// Returns the weights of the six taps along x. Each vector holds the weights of two successive taps for each point.
template <class Lanes>
CCDT_INLINE inline std::array<typename Lanes::Pairs, kTaps / 2> across(const Taps<typename Lanes::Pairs>& taps) {
    return {Lanes::firsts(taps[0], taps[1]), Lanes::firsts(taps[2], taps[3]), Lanes::firsts(taps[4], taps[5])};
}

double sinc(double cycles) {
    const double x = 3.141592653589793 * cycles;
    return x == 0 ? 1 : std::sin(x) / x;
}

std::variant<RealTransform, CosineTransform> make_transform(bool torus, int columns, int rows, Executor& executor,
                                                            std::size_t padded) {
    if (torus) return RealTransform(columns, rows, executor, padded);
    return CosineTransform(columns, rows, executor, padded);
}

}  // namespace

SplineGrid::SplineGrid(bool torus, Point sides, int columns, int rows, Executor& executor)
    : executor_(executor),
      torus_(torus),
      sides_(sides),
      columns_(columns),
      rows_(rows),
      kept_(torus ? columns / 2 + 1 : columns),
      half_cell_{0.5 / columns, 0.5 / rows},
      stride_(static_cast<std::size_t>(columns) + 2 * kMargin),
      transform_(make_transform(torus, columns, rows, executor, padded_size())) {
    assert(sides.x > 0 && sides.y > 0);
    acquire_memory();
    const double waves = torus ? 1 : 0.5;
    const auto windows = [&](int count, int cells) {
        std::vector<double> values;
        for (int i = 0; i < count; ++i) values.push_back(std::pow(sinc(waves * i / cells), static_cast<int>(kTaps)));
        return values;
    };
    column_windows_ = windows(kept_, columns);
    row_windows_ = windows(rows, rows);
}

std::size_t SplineGrid::padded_size() const {
    return stride_ * (static_cast<std::size_t>(rows_) + 2 * kMargin);
}

/// Determines the grid points on which points are spread. On a torus, grid points are at the corners of cells, as in
/// the Fourier transform. In a box, they are at the centres.
template <class Lanes>
CCDT_INLINE inline SplineGrid::Places<Lanes> SplineGrid::places(const std::array<Point, Lanes::kCount>& points) const {
    using Pairs = typename Lanes::Pairs;
    const auto of_each = [](Pair pair) CCDT_INLINE {
        std::array<Pair, Lanes::kCount> same;
        same.fill(pair);
        return Lanes::join(same);
    };
    std::array<Pair, Lanes::kCount> coordinates;
    for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) coordinates[lane] = load(points[lane]);
    const Pairs share = Lanes::join(coordinates) / of_each(load(sides_));
    const Pairs cells = of_each(Pair{static_cast<double>(columns_), static_cast<double>(rows_)});
    const Pairs none{}, all = none + 1.0;
    const Pairs clamped = share < none ? none : all < share ? all : share;
    const Pairs at = (torus_ ? share - Lanes::whole(share) : clamped - of_each(half_cell_)) * cells;
    // Rounding can put a position at the far end of a torus.
    const Pairs last = cells - 1.0, below = Lanes::whole(at), before = last < below ? last : below;
    Places<Lanes> places;
    places.fractions = at - before;
    for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
        const Pair point = Lanes::pair(before, lane) + 1.0;
        places.rows[lane] = static_cast<std::size_t>(point[1]);
        places.first[lane] = places.rows[lane] * stride_ + static_cast<std::size_t>(point[0]);
    }
    return places;
}

void SplineGrid::release_memory() {
    std::visit([](auto& transform) { transform.release_memory(); }, transform_);
    padded_ = {};
}

void SplineGrid::acquire_memory() {
    if (padded_.empty()) padded_ = std::visit([](auto& transform) { return transform.spare(); }, transform_);
}

void SplineGrid::clear() {
    acquire_memory();
    constexpr std::size_t kRange = 65536;
    for_ranges(executor_, padded_.size(), kRange, [&](std::size_t begin, std::size_t end) {
        std::ranges::fill(padded_.subspan(begin, end - begin), 0.0);
    });
}

template <class Lanes>
CCDT_INLINE inline void SplineGrid::spread_few(const std::array<Point, Lanes::kCount>& points,
                                               const std::array<double, Lanes::kCount>& values) {
    const auto [rows, first, fractions] = places<Lanes>(points);
    const auto weights = b_spline<kDegree>(fractions);
    const auto columns = across<Lanes>(weights);
    for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
        std::array<Pair, kTaps / 2> shares;
        for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = values[lane] * Lanes::pair(columns[i], lane);
        const auto share = Row<Lanes>::of(shares);
        double* values_there = padded_.data() + first[lane];
        for (std::size_t j = 0; j < kTaps; ++j, values_there += stride_) {
            auto row = Row<Lanes>::load(values_there);
            row.add(weights[j][2 * lane + 1], share);
            row.store(values_there);
        }
    }
}

void SplineGrid::spread(Point p, double value) {
    spread_few<OneLane>({p}, {value});
}

void SplineGrid::spread_move(Point p, Point move) {
    const auto [rows, first, fraction] = places<OneLane>({p});
    const Taps<Pair> weights = b_spline<kDegree>(fraction), slopes = slopes_at(fraction);
    const Point cell = this->cell();
    std::array<double, kTaps> along_x, across;
    for (std::size_t i = 0; i < kTaps; ++i) {
        along_x[i] = move.x / cell.x * slopes[i][0];
        across[i] = move.y / cell.y * weights[i][0];
    }
    for (std::size_t j = 0; j < kTaps; ++j) {
        double* row = &padded_[first[0] + j * stride_];
        const double weight = weights[j][1], slope = slopes[j][1];
        for (std::size_t i = 0; i < kTaps; ++i) row[i] += weight * along_x[i] + slope * across[i];
    }
}

template <class Lanes>
CCDT_INLINE inline std::array<Point, Lanes::kCount> SplineGrid::gradients_of(
    const std::array<Point, Lanes::kCount>& points) const {
    using Pairs = typename Lanes::Pairs;
    const auto [rows, first, fractions] = places<Lanes>(points);
    const auto weights = b_spline<kDegree>(fractions), slopes = slopes_at(fractions);
    // Sums over columns; each vector holds two successive columns of each point.
    std::array<std::array<Pair, Lanes::kCount>, kTaps / 2> weighted, sloping;
    for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
        Row<Lanes> along_y, slope_y;
        const double* values = padded_.data() + first[lane];
        for (std::size_t j = 0; j < kTaps; ++j, values += stride_) {
            const auto row = Row<Lanes>::load(values);
            along_y.add(weights[j][2 * lane + 1], row);
            slope_y.add(slopes[j][2 * lane + 1], row);
        }
        const auto along_pairs = along_y.pairs(), slope_pairs = slope_y.pairs();
        for (std::size_t i = 0; i < kTaps / 2; ++i) {
            weighted[i][lane] = along_pairs[i];
            sloping[i][lane] = slope_pairs[i];
        }
    }
    Pairs sum{};
    for (std::size_t i = 0; i < kTaps; i += 2) {
        const Pairs along = Lanes::join(weighted[i / 2]), slope = Lanes::join(sloping[i / 2]);
        sum += Lanes::firsts(along, slope) * Lanes::firsts(slopes[i], weights[i]);
        sum += Lanes::seconds(along, slope) * Lanes::firsts(slopes[i + 1], weights[i + 1]);
    }
    const Point cell = this->cell();
    std::array<Point, Lanes::kCount> gradients;
    for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
        const Pair gradient = Lanes::pair(sum, lane);
        gradients[lane] = {gradient[0] / cell.x, gradient[1] / cell.y};
    }
    return gradients;
}

Point SplineGrid::gradient(Point p) const {
    return gradients_of<OneLane>({p})[0];
}

void SplineGrid::gradients(std::span<const Point> points, std::span<Point> gradients) const {
    const std::size_t in_pairs = points.size() / 2 * 2;
    with_lanes([&](auto lanes) CCDT_INLINE {
        using Lanes = decltype(lanes);
        for (std::size_t i = 0; i < in_pairs; i += Lanes::kCount) {
            std::array<Point, Lanes::kCount> few;
            for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) few[lane] = points[i + lane];
            few = gradients_of<Lanes>(few);
            for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) gradients[i + lane] = few[lane];
        }
    });
    if (in_pairs < points.size()) gradients[in_pairs] = gradient(points[in_pairs]);
}

/// Calls add(numbers) with the indices of points, in groups. Leaves out points for which counts(index) is false. The
/// rows of the grid are divided into bands. First the even bands are processed in parallel, then the odd bands: taps
/// reach no further than the next band.
template <class Counts, class Add>
void SplineGrid::add_all(std::span<const Point> points, Counts&& counts, Add&& add) {
    // With fewer points, sorting costs more than it gains. This number is also the size of a task.
    constexpr std::size_t kPointsPerTask = 8192;
    std::vector<std::uint32_t> order;
    if (points.size() <= kPointsPerTask) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (counts(i)) order.push_back(static_cast<std::uint32_t>(i));
        }
        return add(order);
    }
    const std::size_t bands = static_cast<std::size_t>(rows_) / kRows + 1;
    const std::size_t parts = (points.size() + kPointsPerTask - 1) / kPointsPerTask;
    const auto band_of = [&](std::size_t i) { return places<OneLane>({points[i]}).rows[0] / kRows; };
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

void SplineGrid::spread(std::span<const Point> points, std::span<const double> values) {
    const auto value = [&](std::size_t i) { return values.empty() ? 1 : values[i]; };
    const auto counts = [&](std::size_t i) { return value(i) != 0; };
    add_all(points, counts, [&](std::span<const std::uint32_t> numbers) {
        const std::size_t in_pairs = numbers.size() / 2 * 2;
        with_lanes([&](auto lanes) CCDT_INLINE {
            using Lanes = decltype(lanes);
            for (std::size_t i = 0; i < in_pairs; i += Lanes::kCount) {
                std::array<Point, Lanes::kCount> few;
                std::array<double, Lanes::kCount> of_few;
                for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
                    few[lane] = points[numbers[i + lane]];
                    of_few[lane] = value(numbers[i + lane]);
                }
                spread_few<Lanes>(few, of_few);
            }
        });
        if (in_pairs < numbers.size()) spread(points[numbers[in_pairs]], value(numbers[in_pairs]));
    });
}

void SplineGrid::spread_moves(std::span<const Point> points, std::span<const Point> moves) {
    const auto each = [](std::size_t) { return true; };
    add_all(points, each, [&](std::span<const std::uint32_t> numbers) {
        for (const std::uint32_t i : numbers) spread_move(points[i], moves[i]);
    });
}

void SplineGrid::transform() {
    fold();
    forward();
}

void SplineGrid::transform_back() {
    backward();
    unfold();
}

/// Adds the values in the margins to the cells that the margins repeat, and moves the sums to the grid.
void SplineGrid::fold() {
    const auto rows = static_cast<std::size_t>(rows_), columns = static_cast<std::size_t>(columns_);
    for_ranges(executor_, rows, kRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            double* const own = padded_row(kMargin + row);
            for_margins([&](std::size_t i, std::size_t inside) { own[inside] += own[i]; });
        }
    });
    for_margin_rows([&](const double* row, double* inside) {
        for_margins([&](std::size_t i, std::size_t to) { inside[to] += row[i]; });
        for (std::size_t i = kMargin; i < kMargin + columns; ++i) inside[i] += row[i];
    });
    double* const cells = grid().data();
    // In a box, the cells overlap the padded rows: a row may be moved only after the rows before it.
    for_ranges(torus_ ? executor_ : inline_executor(), rows, kRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row)
            std::copy_n(padded_row(kMargin + row) + kMargin, columns, cells + row * columns);
    });
}

/// Moves the grid's values to the padded rows, and fills the margins by periodic or mirrored repetition.
void SplineGrid::unfold() {
    const auto rows = static_cast<std::size_t>(rows_), columns = static_cast<std::size_t>(columns_);
    const double* const cells = grid().data();
    const auto move = [&](std::size_t row) {
        const double* const from = cells + row * columns;
        std::copy_backward(from, from + columns, padded_row(kMargin + row) + kMargin + columns);
    };
    for (std::size_t row = torus_ ? 0 : rows; row-- > 0;) move(row);  // in a box, the cells overlap the padded rows
    for_ranges(executor_, rows, kRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            if (torus_) move(row);
            double* const own = padded_row(kMargin + row);
            for_margins([&](std::size_t i, std::size_t inside) { own[i] = own[inside]; });
        }
    });
    for_margin_rows([&](double* row, const double* inside) { std::copy(inside, inside + stride_, row); });
}

std::span<double> SplineGrid::grid() {
    return std::visit([](auto& transform) { return transform.grid(); }, transform_);
}

void SplineGrid::forward() {
    std::visit([](auto& transform) { transform.forward(); }, transform_);
}

void SplineGrid::backward() {
    std::visit([](auto& transform) { transform.backward(); }, transform_);
}

/// Maps an index in a padded row or column to the grid.
std::size_t SplineGrid::folded(std::size_t padded, int cells) const {
    const int i = static_cast<int>(padded) - static_cast<int>(kMargin);
    const int period = torus_ ? cells : 2 * cells;
    const int k = ((i % period) + period) % period;
    return static_cast<std::size_t>(k < cells ? k : period - 1 - k);
}

/// Calls visit(index in a padded row, index of the cell repeated there) for all margin cells of a row.
template <class Visit>
void SplineGrid::for_margins(Visit&& visit) const {
    for (std::size_t i = 0; i < kMargin; ++i) {
        const std::size_t last = kMargin + static_cast<std::size_t>(columns_) + i;
        visit(i, kMargin + folded(i, columns_));
        visit(last, kMargin + folded(last, columns_));
    }
}

/// Calls visit(margin row, row repeated there) for all margin rows.
template <class Visit>
void SplineGrid::for_margin_rows(Visit&& visit) {
    for (std::size_t i = 0; i < kMargin; ++i) {
        for (const std::size_t row : {i, kMargin + static_cast<std::size_t>(rows_) + i})
            visit(padded_row(row), padded_row(kMargin + folded(row, rows_)));
    }
}

}  // namespace ccdt
