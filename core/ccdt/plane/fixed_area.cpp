// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/fixed_area.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <tuple>

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// Finds the nearest fixed point of each cell of a grid.
class NearestFixed {
public:
    NearestFixed(const Domain& domain, std::span<const Point> fixed, int columns, int rows)
        : fixed_(fixed),
          torus_(domain.is_torus()),
          sides_(domain.unit_bounds().max),
          columns_(columns),
          rows_(rows),
          cell_{sides_.x / columns, sides_.y / rows},
          nearest_(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), kNone) {
        const auto index = [](double position, double side, int cells) {
            return static_cast<int>(std::clamp(position / side * cells, 0.0, cells - 1.0));
        };
        for (std::uint32_t i = 0; i < fixed.size(); ++i)
            offer(index(fixed[i].x, sides_.x, columns), index(fixed[i].y, sides_.y, rows), i);
        // On a torus, a second sweep propagates points across the seam.
        for (int i = 0; i < (torus_ ? 2 : 1); ++i) sweep();
    }

    std::uint32_t at(std::size_t cell) const { return nearest_[cell]; }

    double distance(std::size_t cell) const {
        const auto width = static_cast<std::size_t>(columns_);
        const double squared =
            squared_distance(static_cast<int>(cell % width), static_cast<int>(cell / width), nearest_[cell]);
        return std::sqrt(squared);
    }

private:
    double squared_distance(int column, int row, std::uint32_t point) const {
        Point off = fixed_[point] - Point{(column + 0.5) * cell_.x, (row + 0.5) * cell_.y};
        if (torus_) off = {std::remainder(off.x, sides_.x), std::remainder(off.y, sides_.y)};
        return dot(off, off);
    }

    std::uint32_t& cell(int column, int row) {
        return nearest_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                        static_cast<std::size_t>(column)];
    }

    void offer(int column, int row, std::uint32_t point) {
        std::uint32_t& known = cell(column, row);
        if (point == kNone || point == known) return;
        if (known == kNone || squared_distance(column, row, point) < squared_distance(column, row, known))
            known = point;
    }

    /// Compares the nearest point of a cell with the nearest point of a neighbouring cell, and keeps the nearer one.
    /// @param across, up  columns and rows from the cell to its neighbour
    void ask(int column, int row, int across, int up) {
        int from_column = column + across, from_row = row + up;
        if (torus_) {
            from_column = (from_column + columns_) % columns_;
            from_row = (from_row + rows_) % rows_;
        }
        if (from_column < 0 || from_column >= columns_ || from_row < 0 || from_row >= rows_) return;
        offer(column, row, cell(from_column, from_row));
    }

    void sweep_row(int row, int up) {
        for (int column = 0; column < columns_; ++column) {
            for (const int across : {-1, 0, 1}) ask(column, row, across, up);
            ask(column, row, -1, 0);
        }
        for (int column = columns_; column-- > 0;) ask(column, row, 1, 0);
    }

    void sweep() {
        for (int row = 0; row < rows_; ++row) sweep_row(row, -1);
        for (int row = rows_; row-- > 0;) sweep_row(row, 1);
    }

    std::span<const Point> fixed_;
    bool torus_;
    Point sides_;
    int columns_, rows_;
    Point cell_;
    std::vector<std::uint32_t> nearest_;  ///< [rows * columns] nearest fixed point of each cell
};

}  // namespace

std::vector<Point> to_unit_frame(const Domain& domain, std::span<const Point> points) {
    constexpr double kFar = 1;  // distance from the box
    const double scale = std::max(domain.bounds().width(), domain.bounds().height());
    const Point sides = domain.unit_bounds().max;
    std::vector<Point> result;
    for (const Point& p : points) {
        const Point unit = domain.is_torus() ? domain.to_unit(p) : (1 / scale) * (p - domain.bounds().min);
        if (unit.x > -kFar && unit.x < sides.x + kFar && unit.y > -kFar && unit.y < sides.y + kFar)
            result.push_back(unit);
    }
    // Sorts in boustrophedon order, so that each point is near its predecessor.
    const double bands = std::sqrt(static_cast<double>(result.size()));
    const auto position = [&](Point p) {
        const double band = std::floor(p.y * bands);
        return std::tuple(band, std::fmod(band, 2) == 0 ? p.x : -p.x, p.y);
    };
    std::ranges::sort(result, {}, position);
    return result;
}

FixedArea subtract_fixed_area(const Domain& domain, std::span<const Point> fixed, std::size_t sites, int columns,
                              int rows, std::span<double> masses) {
    constexpr int kHalvings = 40;
    const NearestFixed nearest(domain, fixed, columns, rows);
    const Point side{domain.unit_bounds().width() / columns, domain.unit_bounds().height() / rows};
    const double cell = side.x * side.y, softness = 0.5 * std::sqrt(cell);
    const auto count = static_cast<double>(sites);

    std::vector<float> distances(masses.size());
    double total = 0;
    for (std::size_t i = 0; i < masses.size(); ++i) {
        total += masses[i];
        distances[i] = static_cast<float>(nearest.distance(i));
    }
    const auto taken = [&](std::size_t i, double each) {
        const double radius = std::sqrt(each * cell / (std::numbers::pi * masses[i]));
        return std::clamp(0.5 + (radius - static_cast<double>(distances[i])) / (2 * softness), 0.0, 1.0) * masses[i];
    };
    double least = 0, most = total / count;
    for (int i = 0; i < kHalvings; ++i) {
        const double each = (least + most) / 2;
        double covered = 0;
        for (std::size_t k = 0; k < masses.size(); ++k) {
            if (masses[k] > 0) covered += taken(k, each);
        }
        (count * each + covered > total ? most : least) = each;
    }
    // If even the least share leaves no area, the upper bound is used, so that new sites get some area.
    const double each = least > 0 ? least : most;
    FixedArea result{total / each, std::vector<double>(fixed.size(), 0)};
    for (std::size_t i = 0; i < masses.size(); ++i) {
        if (!(masses[i] > 0)) continue;
        const double part = taken(i, each);
        result.weights[nearest.at(i)] += part / each;
        masses[i] -= part;
    }
    for (double& weight : result.weights) weight = std::min(weight, 1.0);
    return result;
}

}  // namespace ccdt
