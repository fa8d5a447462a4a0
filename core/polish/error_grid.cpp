#include "core/polish/error_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ccdt {

namespace {

constexpr std::size_t kTaps = 4;
constexpr double kMostCells = 64;  ///< of the grid for each site; a domain may fill next to nothing of its box

/// The cubic B-spline at the four grid points around.
inline std::array<double, kTaps> weights_at(double f) {
    const double g = 1 - f;
    return {g * g * g / 6, 2.0 / 3 - f * f * (1 - f / 2), 2.0 / 3 - g * g * (1 - g / 2), f * f * f / 6};
}

double cell_side(Point sides, double cell, std::size_t sites) {
    return std::max(cell, std::sqrt(sides.x * sides.y / (kMostCells * static_cast<double>(sites))));
}

std::size_t cells(double side, double cell) {
    return static_cast<std::size_t>(std::ceil(side / cell)) + 1;
}

}  // namespace

ErrorGrid::ErrorGrid(Point sides, double cell, std::size_t sites, std::span<const BorderEdge> border,
                     const Density& density)
    : cell_(cell_side(sides, cell, sites)),
      columns_(cells(sides.x, cell_) + kTaps - 1),
      rows_(cells(sides.y, cell_) + kTaps - 1),
      wanted_(columns_ * rows_, 0),
      values_(columns_ * rows_, 0) {
    constexpr std::size_t kPieces = 2;  // areas are spread in pieces of half a cell, each from its middle
    const std::size_t columns = kPieces * cells(sides.x, cell_), rows = kPieces * cells(sides.y, cell_);
    auto masses = coverage(border, sides, static_cast<int>(columns), static_cast<int>(rows));
    if (!density.is_uniform()) {
        std::vector<double> values(columns);
        for (std::size_t row = 0; row < rows; ++row) {
            density.resample_row(density.cells(), static_cast<int>(columns), static_cast<int>(rows),
                                 static_cast<int>(row), values);
            for (std::size_t column = 0; column < columns; ++column) masses[row * columns + column] *= values[column];
        }
    }
    double all = 0;
    for (const double mass : masses) all += mass;
    if (!(all > 0)) return;
    for (double& mass : masses) mass *= static_cast<double>(sites) / all;
    want(masses, columns, rows, {sides.x / static_cast<double>(columns), sides.y / static_cast<double>(rows)});
}

/// Spreads pieces of areas: along rows, then along columns.
/// @param side  of the pieces
void ErrorGrid::want(const std::vector<double>& masses, std::size_t columns, std::size_t rows, Point side) {
    std::vector<double> lines(columns_ * rows, 0);
    for (std::size_t column = 0; column < columns; ++column) {
        const auto [first, fraction] = place({(static_cast<double>(column) + 0.5) * side.x, 0});
        const auto weights = weights_at(fraction.x);
        for (std::size_t row = 0; row < rows; ++row) {
            const double mass = masses[row * columns + column];
            if (mass == 0) continue;
            for (std::size_t k = 0; k < kTaps; ++k) lines[row * columns_ + first + k] += weights[k] * mass;
        }
    }
    for (std::size_t row = 0; row < rows; ++row) {
        const auto [first, fraction] = place({0, (static_cast<double>(row) + 0.5) * side.y});
        const auto weights = weights_at(fraction.y);
        for (std::size_t k = 0; k < kTaps; ++k) {
            double* to = &wanted_[first + k * columns_];
            const double* from = &lines[row * columns_];
            for (std::size_t column = 0; column < columns_; ++column) to[column] += weights[k] * from[column];
        }
    }
}

void ErrorGrid::measure(std::span<const Point> sites) {
    std::ranges::fill(values_, 0.0);
    for (const Point p : sites) {
        const auto [first, fraction] = place(p);
        const auto across = weights_at(fraction.x), up = weights_at(fraction.y);
        for (std::size_t j = 0; j < kTaps; ++j) {
            double* row = &values_[first + j * columns_];
            for (std::size_t i = 0; i < kTaps; ++i) row[i] += up[j] * across[i];
        }
    }
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = values_[i] > 0 ? 1 - wanted_[i] / values_[i] : 0;
}

double ErrorGrid::at(Point site) const {
    const auto [first, fraction] = place(site);
    const auto across = weights_at(fraction.x), up = weights_at(fraction.y);
    double sum = 0;
    for (std::size_t j = 0; j < kTaps; ++j) {
        const double* row = &values_[first + j * columns_];
        double line = 0;
        for (std::size_t i = 0; i < kTaps; ++i) line += across[i] * row[i];
        sum += up[j] * line;
    }
    return sum;
}

}  // namespace ccdt
