// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/error_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/spreading.h"

namespace ccdt {

namespace {

constexpr int kDegree = 3;
constexpr std::size_t kTaps = kDegree + 1;
/// Limit on the box's grid points per site. Needed because a domain may fill very little of its bounding box, and
/// because a box may be much longer than wide: each row and column has at least kTaps points.
constexpr double kMaxPoints = 64;

double cell_side(Point sides, double cell, std::size_t sites) {
    const double most = kMaxPoints * static_cast<double>(sites);
    return std::max({cell, std::sqrt(sides.x * sides.y / most), std::max(sides.x, sides.y) * kTaps / most});
}

std::size_t cells(double side, double cell) {
    return static_cast<std::size_t>(std::ceil(side / cell)) + 1;
}

}  // namespace

ErrorGrid::ErrorGrid(Point sides, double cell, std::size_t sites, std::span<const BorderEdge> border,
                     const Density& density)
    : cell_(cell_side(sides, cell, sites)),
      columns_(cells(sides.x, cell_) + kTaps - 1),
      rows_(cells(sides.y, cell_) + kTaps - 1) {
    constexpr std::size_t kPieces = 2;  // areas are spread in pieces of half a cell, each piece at its centre
    const std::size_t columns = kPieces * cells(sides.x, cell_), rows = kPieces * cells(sides.y, cell_);
    auto masses = crossed_coverage(border, sides, static_cast<int>(columns), static_cast<int>(rows));
    if (!density.is_uniform()) {
        std::vector<double> values(columns);
        for (std::size_t number = 0; number < rows; ++number) {
            const CrossedCells::Row& row = masses.rows[number];
            if (row.first == row.end) continue;
            density.resample_row(density.cells(), static_cast<int>(columns), static_cast<int>(rows),
                                 static_cast<int>(number), values);
            for (std::size_t column = row.first; column < row.end; ++column)
                masses.values[row.number + column - row.first] *= values[column];
        }
    }
    const Point side{sides.x / static_cast<double>(columns), sides.y / static_cast<double>(rows)};
    choose_stored(masses, side);
    double all = 0;
    for (const double mass : masses.values) all += mass;
    if (!(all > 0)) return;
    for (double& mass : masses.values) mass *= static_cast<double>(sites) / all;
    spread_wanted(masses, side);
}

/// Selects the grid points to store: all points on which a site in one of the pieces can be spread.
/// @param pieces  the pieces of the box that contain a part of the areas
/// @param side    size of the pieces
void ErrorGrid::choose_stored(const CrossedCells& pieces, Point side) {
    constexpr double kMargin = 0.5;  // in pieces; rounding can move a point beyond the side of a piece
    struct Range {
        std::size_t first, end;
    };
    std::vector<Range> ranges(rows_, {columns_, 0});
    const auto cell = [&](double piece, double length, std::size_t count) {
        return std::min(static_cast<std::size_t>(std::max(0.0, piece * length / cell_)), count - kTaps);
    };
    for (std::size_t number = 0; number < pieces.rows.size(); ++number) {
        const CrossedCells::Row& row = pieces.rows[number];
        if (row.first == row.end) continue;
        const std::size_t first = cell(static_cast<double>(row.first) - kMargin, side.x, columns_);
        const std::size_t end = cell(static_cast<double>(row.end) + kMargin, side.x, columns_) + kTaps;
        const std::size_t last = cell(static_cast<double>(number + 1) + kMargin, side.y, rows_) + kTaps;
        for (std::size_t j = cell(static_cast<double>(number) - kMargin, side.y, rows_); j < last; ++j)
            ranges[j] = {std::min(ranges[j].first, first), std::max(ranges[j].end, end)};
    }
    std::size_t count = 0;
    for (const Range& range : ranges) {
        numbers_.push_back(count - range.first);
        if (range.end > range.first) count += range.end - range.first;
    }
    wanted_.assign(count, 0);
    values_.assign(count, 0);
}

/// Spreads the masses of the pieces on the grid, first along rows, then across rows.
/// @param side  size of the pieces
void ErrorGrid::spread_wanted(const CrossedCells& masses, Point side) {
    std::vector<double> line(columns_, 0);
    for (std::size_t number = 0; number < masses.rows.size(); ++number) {
        const CrossedCells::Row& row = masses.rows[number];
        if (row.first == row.end) continue;
        const auto middle = [](std::size_t piece, double length) {
            return (static_cast<double>(piece) + 0.5) * length;
        };
        for (std::size_t piece = row.first; piece < row.end; ++piece) {
            const double mass = masses.values[row.number + piece - row.first];
            if (mass == 0) continue;
            const auto at = position({middle(piece, side.x), 0});
            const auto weights = b_spline<kDegree>(at.fraction.x);
            for (std::size_t k = 0; k < kTaps; ++k) line[at.column + k] += weights[k] * mass;
        }
        const std::size_t first = position({middle(row.first, side.x), 0}).column;
        const std::size_t end = position({middle(row.end - 1, side.x), 0}).column + kTaps;
        const auto up = position({0, middle(number, side.y)});
        const auto weights = b_spline<kDegree>(up.fraction.y);
        for (std::size_t k = 0; k < kTaps; ++k) {
            for (std::size_t column = first; column < end; ++column)
                wanted_[this->number(column, up.row + k)] += weights[k] * line[column];
        }
        std::fill(line.begin() + static_cast<std::ptrdiff_t>(first), line.begin() + static_cast<std::ptrdiff_t>(end),
                  0.0);
    }
}

void ErrorGrid::measure(std::span<const Point> sites) {
    std::ranges::fill(values_, 0.0);
    for (const Point p : sites) {
        const auto [column, row, fraction] = position(p);
        for_taps(b_spline<kDegree>(fraction.x), b_spline<kDegree>(fraction.y), 1.0,
                 [&, column = column, row = row](std::size_t j, std::size_t i, double share) {
                     values_[number(column, row + j) + i] += share;
                 });
    }
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = values_[i] > 0 ? 1 - wanted_[i] / values_[i] : 0;
}

double ErrorGrid::at(Point site) const {
    const auto [column, row, fraction] = position(site);
    return sum_taps(b_spline<kDegree>(fraction.x), b_spline<kDegree>(fraction.y),
                    [&, column = column, row = row](std::size_t j) { return &values_[number(column, row + j)]; });
}

}  // namespace ccdt
