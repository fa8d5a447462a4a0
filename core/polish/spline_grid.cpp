#include "core/polish/spline_grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <utility>

namespace ccdt {

namespace {

constexpr std::size_t kTaps = 6;
constexpr std::size_t kMargin = 3;  ///< cells that taps reach beyond the grid

using Taps = std::array<Pair, kTaps>;

/// The quintic B-spline at the six grid points around, for x and y together.
inline Taps weights_at(Pair f) {
    const auto outer = [](Pair d) {  // at distance 2 + d
        const Pair g = 1.0 - d, g2 = g * g;
        return g2 * g2 * g * (1.0 / 120);
    };
    const auto inner = [](Pair d) {  // at distance 1 + d
        const Pair x = 1.0 + d;
        return 17.0 / 40 + x * (5.0 / 8 + x * (-7.0 / 4 + x * (5.0 / 4 + x * (-3.0 / 8 + x * (1.0 / 24)))));
    };
    const auto middle = [](Pair d) {  // at distance d
        const Pair d2 = d * d;
        return 11.0 / 20 + d2 * (-0.5 + d2 * (0.25 - d * (1.0 / 12)));
    };
    const Pair g = 1.0 - f;
    return {outer(f), inner(f), middle(f), middle(g), inner(g), outer(g)};
}

/// Slopes of the six weights.
inline Taps slopes_at(Pair f) {
    const auto outer = [](Pair d) {
        const Pair g = 1.0 - d, g2 = g * g;
        return g2 * g2 * (-1.0 / 24);
    };
    const auto inner = [](Pair d) {
        const Pair x = 1.0 + d;
        return 5.0 / 8 + x * (-7.0 / 2 + x * (15.0 / 4 + x * (-3.0 / 2 + x * (5.0 / 24))));
    };
    const auto middle = [](Pair d) { return d * (-1.0 + d * d * (1.0 - d * (5.0 / 12))); };
    const Pair g = 1.0 - f;
    return {outer(f), inner(f), middle(f), -middle(g), -inner(g), -outer(g)};
}

double sinc(double cycles) {
    const double x = 3.141592653589793 * cycles;
    return x == 0 ? 1 : std::sin(x) / x;
}

std::variant<RealTransform, CosineTransform> make_transform(bool torus, int columns, int rows, Team& team,
                                                            std::size_t padded) {
    if (torus) return RealTransform(columns, rows, team, padded);
    return CosineTransform(columns, rows, team, padded);
}

}  // namespace

SplineGrid::SplineGrid(bool torus, Point sides, int columns, int rows, Team& team)
    : team_(team),
      torus_(torus),
      sides_(sides),
      columns_(columns),
      rows_(rows),
      kept_(torus ? columns / 2 + 1 : columns),
      stride_(static_cast<std::size_t>(columns) + 2 * kMargin),
      transform_(make_transform(torus, columns, rows, team, padded_size())) {
    assert(sides.x > 0 && sides.y > 0);
    take_room();
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

/// Where a point lies along one side, in cells from the first grid point. Grid points are cells' corners on a torus, as
/// Fourier's transform has them, and cells' middles in a box.
inline double SplineGrid::along(double coordinate, double side, int cells) const {
    const double share = coordinate / side;
    return (torus_ ? share - whole(share) : std::clamp(share, 0.0, 1.0) - 0.5 / cells) * cells;
}

/// The last grid point at or before a place along one side, -1 for those before the first.
inline double SplineGrid::point_before(double place, int cells) {
    return std::min(whole(place), cells - 1.0);  // rounding may make a place on a torus its far end
}

inline SplineGrid::Place SplineGrid::place(Point p) const {
    const double x = along(p.x, sides_.x, columns_), y = along(p.y, sides_.y, rows_);
    const double i = point_before(x, columns_), j = point_before(y, rows_);
    return {static_cast<std::size_t>(j + 1) * stride_ + static_cast<std::size_t>(i + 1), Pair{x - i, y - j}};
}

/// Row of the padded grid where the taps of a point begin.
inline std::size_t SplineGrid::first_row(Point p) const {
    return static_cast<std::size_t>(point_before(along(p.y, sides_.y, rows_), rows_) + 1);
}

void SplineGrid::rest() {
    std::visit([](auto& transform) { transform.rest(); }, transform_);
    padded_ = {};
}

void SplineGrid::take_room() {
    if (padded_.empty()) padded_ = std::visit([](auto& transform) { return transform.spare(); }, transform_);
}

void SplineGrid::clear() {
    take_room();
    constexpr std::size_t kRange = 65536;
    for_ranges(team_, padded_.size(), kRange, [&](std::size_t begin, std::size_t end) {
        std::ranges::fill(padded_.subspan(begin, end - begin), 0.0);
    });
}

void SplineGrid::spread(Point p, double value) {
    const auto [first, fraction] = place(p);
    const Taps weights = weights_at(fraction);
    std::array<double, kTaps> across;
    for (std::size_t i = 0; i < kTaps; ++i) across[i] = value * weights[i][0];
    for (std::size_t j = 0; j < kTaps; ++j) {
        double* row = &padded_[first + j * stride_];
        const double weight = weights[j][1];
        for (std::size_t i = 0; i < kTaps; ++i) row[i] += weight * across[i];
    }
}

void SplineGrid::spread_move(Point p, Point move) {
    const auto [first, fraction] = place(p);
    const Taps weights = weights_at(fraction), slopes = slopes_at(fraction);
    const Point cell = this->cell();
    std::array<double, kTaps> along_x, across;
    for (std::size_t i = 0; i < kTaps; ++i) {
        along_x[i] = move.x / cell.x * slopes[i][0];
        across[i] = move.y / cell.y * weights[i][0];
    }
    for (std::size_t j = 0; j < kTaps; ++j) {
        double* row = &padded_[first + j * stride_];
        const double weight = weights[j][1], slope = slopes[j][1];
        for (std::size_t i = 0; i < kTaps; ++i) row[i] += weight * along_x[i] + slope * across[i];
    }
}

Point SplineGrid::gradient(Point p) const {
    const auto [first, fraction] = place(p);
    const Taps weights = weights_at(fraction), slopes = slopes_at(fraction);
    std::array<double, kTaps> along_y{}, slope_y{};  // the columns, summed
    for (std::size_t j = 0; j < kTaps; ++j) {
        const double* row = &padded_[first + j * stride_];
        const double weight = weights[j][1], slope = slopes[j][1];
        for (std::size_t i = 0; i < kTaps; ++i) {
            along_y[i] += weight * row[i];
            slope_y[i] += slope * row[i];
        }
    }
    Point sum;
    for (std::size_t i = 0; i < kTaps; ++i) {
        sum.x += along_y[i] * slopes[i][0];
        sum.y += slope_y[i] * weights[i][0];
    }
    const Point cell = this->cell();
    return {sum.x / cell.x, sum.y / cell.y};
}

/// Calls add(number) for each point that counts. The rows of the grid are divided into bands: points of one band follow
/// each other, and are added at the same time as those of the bands beyond the next, which their taps do not reach.
template <class Counts, class Add>
void SplineGrid::add_all(std::span<const Point> points, Counts&& counts, Add&& add) {
    constexpr std::size_t kFew = 8192;  // of which the lists below take longer than they are worth; also of a task
    if (points.size() <= kFew) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (counts(i)) add(i);
        }
        return;
    }
    const std::size_t bands = static_cast<std::size_t>(rows_) / kRows + 1;
    const std::size_t parts = (points.size() + kFew - 1) / kFew;
    const auto band_of = [&](std::size_t i) { return first_row(points[i]) / kRows; };
    std::vector<std::uint32_t> next(parts * bands, 0);  // place in the order for a part's next point of each band
    for_ranges(team_, points.size(), kFew, [&](std::size_t begin, std::size_t end) {
        std::uint32_t* const count = &next[begin / kFew * bands];
        for (std::size_t i = begin; i < end; ++i) {
            if (counts(i)) ++count[band_of(i)];
        }
    });
    std::vector<std::uint32_t> begins{0};  // [bands + 1]
    for (std::size_t band = 0; band < bands; ++band) {
        std::uint32_t begin = begins.back();
        for (std::size_t part = 0; part < parts; ++part) begin += std::exchange(next[part * bands + band], begin);
        begins.push_back(begin);
    }
    std::vector<std::uint32_t> order(begins.back());
    for_ranges(team_, points.size(), kFew, [&](std::size_t begin, std::size_t end) {
        std::uint32_t* const next_of = &next[begin / kFew * bands];
        for (std::size_t i = begin; i < end; ++i) {
            if (counts(i)) order[next_of[band_of(i)]++] = static_cast<std::uint32_t>(i);
        }
    });
    for (std::size_t odd = 0; odd < 2; ++odd) {
        team_.run((bands + 1 - odd) / 2, [&](std::size_t number) {
            const std::size_t band = 2 * number + odd;
            for (std::uint32_t i = begins[band]; i < begins[band + 1]; ++i) add(order[i]);
        });
    }
}

void SplineGrid::spread(std::span<const Point> points, std::span<const double> values) {
    const auto each = [](std::size_t) { return true; };
    if (values.empty()) return add_all(points, each, [&](std::size_t i) { spread(points[i], 1); });
    const auto counts = [&](std::size_t i) { return values[i] != 0; };
    add_all(points, counts, [&](std::size_t i) { spread(points[i], values[i]); });
}

void SplineGrid::spread_moves(std::span<const Point> points, std::span<const Point> moves) {
    const auto each = [](std::size_t) { return true; };
    add_all(points, each, [&](std::size_t i) { spread_move(points[i], moves[i]); });
}

void SplineGrid::transform() {
    if (torus_) {
        fold();
    } else {
        close_up();
    }
    forward();
}

void SplineGrid::transform_back() {
    backward();
    if (torus_) {
        unfold();
    } else {
        open_up();
    }
}

/// Adds up on the grid what was spread, that beyond it where it belongs.
void SplineGrid::fold() {
    const std::span<double> cells = grid();
    const auto rows = static_cast<std::size_t>(rows_);
    const auto add = [&](double& padded, std::size_t cell) { cells[cell] += padded; };
    for_ranges(team_, rows, kRows, [&](std::size_t begin, std::size_t end) {
        std::fill(cells.begin() + static_cast<std::ptrdiff_t>(begin * static_cast<std::size_t>(columns_)),
                  cells.begin() + static_cast<std::ptrdiff_t>(end * static_cast<std::size_t>(columns_)), 0.0);
        for (std::size_t row = begin; row < end; ++row) for_padded(kMargin + row, add);
    });
    for (std::size_t row = 0; row < kMargin; ++row) {
        for_padded(row, add);
        for_padded(kMargin + rows + row, add);
    }
}

/// Copies the grid's values, and around it those that are repeated there.
void SplineGrid::unfold() {
    const std::span<double> cells = grid();
    for_ranges(team_, static_cast<std::size_t>(rows_) + 2 * kMargin, kRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row)
            for_padded(row, [&](double& padded, std::size_t cell) { padded = cells[cell]; });
    });
}

/// The same as fold() where both lie in one memory: the grid's rows move up to each other once all is added to them.
void SplineGrid::close_up() {
    const auto rows = static_cast<std::size_t>(rows_), columns = static_cast<std::size_t>(columns_);
    for_ranges(team_, rows, kRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            double* const own = padded_row(kMargin + row);
            for_margins([&](std::size_t i, std::size_t inside) { own[inside] += own[i]; });
        }
    });
    for_margin_rows([&](const double* row, double* inside) {
        for_margins([&](std::size_t i, std::size_t to) { inside[to] += row[i]; });
        for (std::size_t i = kMargin; i < kMargin + columns; ++i) inside[i] += row[i];
    });
    for (std::size_t row = 0; row < rows; ++row) {
        const double* const from = padded_row(kMargin + row) + kMargin;
        std::copy(from, from + columns, padded_.data() + row * columns);
    }
}

/// The same as unfold() where both lie in one memory.
void SplineGrid::open_up() {
    const auto rows = static_cast<std::size_t>(rows_), columns = static_cast<std::size_t>(columns_);
    for (std::size_t row = rows; row-- > 0;) {
        const double* const from = padded_.data() + row * columns;
        std::copy_backward(from, from + columns, padded_row(kMargin + row) + kMargin + columns);
    }
    for_ranges(team_, rows, kRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
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

/// Index within a row or column of the grid of one with margins.
std::size_t SplineGrid::folded(std::size_t padded, int cells) const {
    const int i = static_cast<int>(padded) - static_cast<int>(kMargin);
    const int period = torus_ ? cells : 2 * cells;
    const int k = ((i % period) + period) % period;
    return static_cast<std::size_t>(k < cells ? k : period - 1 - k);
}

/// Calls visit(place in a row with margins, place there that it repeats) for all margins of a row.
template <class Visit>
void SplineGrid::for_margins(Visit&& visit) const {
    for (std::size_t i = 0; i < kMargin; ++i) {
        const std::size_t last = kMargin + static_cast<std::size_t>(columns_) + i;
        visit(i, kMargin + folded(i, columns_));
        visit(last, kMargin + folded(last, columns_));
    }
}

/// Calls visit(row, row that it repeats) for all rows beyond the grid.
template <class Visit>
void SplineGrid::for_margin_rows(Visit&& visit) {
    for (std::size_t i = 0; i < kMargin; ++i) {
        for (const std::size_t row : {i, kMargin + static_cast<std::size_t>(rows_) + i})
            visit(padded_row(row), padded_row(kMargin + folded(row, rows_)));
    }
}

/// Calls visit(value, number of the cell) for a row of the grid with margins.
template <class Visit>
void SplineGrid::for_padded(std::size_t number, Visit&& visit) {
    const auto columns = static_cast<std::size_t>(columns_);
    const std::size_t start = folded(number, rows_) * columns;
    double* row = &padded_[number * stride_];
    for (std::size_t i = 0; i < kMargin; ++i) {
        visit(row[i], start + folded(i, columns_));
        visit(row[kMargin + columns + i], start + folded(kMargin + columns + i, columns_));
    }
    for (std::size_t i = 0; i < columns; ++i) visit(row[kMargin + i], start + i);
}

}  // namespace ccdt
