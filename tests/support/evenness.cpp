// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/evenness.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/ccdt/polish/cell_list.h"
#include "core/density/coverage.h"
#include "core/geometry/hexagonal_spacing.h"

namespace ccdt::test {

namespace {

/// Values of the cells of a grid.
struct Raster {
    std::size_t columns, rows;
    std::vector<double> values;

    double& at(std::size_t column, std::size_t row) { return values[row * columns + column]; }
};

/// Blurs each line of values by a Gaussian; values beyond its ends are 0.
/// @param line_step  distance between the first values of two lines
/// @param step       distance between two values of a line
/// @param sigma      standard deviation of the Gaussian, in cells
void blur_lines(std::vector<double>& values, std::size_t lines, std::size_t length, std::size_t line_step,
                std::size_t step, double sigma) {
    const auto reach = static_cast<std::size_t>(std::ceil(4.5 * sigma));
    std::vector<double> weights, line(length + 2 * reach, 0);
    double sum = 0;
    for (std::size_t k = 0; k <= 2 * reach; ++k) {
        const double distance = (static_cast<double>(k) - static_cast<double>(reach)) / sigma;
        sum += weights.emplace_back(std::exp(-distance * distance / 2));
    }
    for (double& weight : weights) weight /= sum;
    for (std::size_t number = 0; number < lines; ++number) {
        double* first = &values[number * line_step];
        for (std::size_t i = 0; i < length; ++i) line[reach + i] = first[i * step];
        for (std::size_t i = 0; i < length; ++i) {
            double blurred = 0;
            for (std::size_t k = 0; k < weights.size(); ++k) blurred += weights[k] * line[i + k];
            first[i * step] = blurred;
        }
    }
}

Raster blurred(Raster raster, double sigma) {
    blur_lines(raster.values, raster.rows, raster.columns, raster.columns, 1, sigma);
    blur_lines(raster.values, raster.columns, raster.rows, 1, raster.columns, sigma);
    return raster;
}

std::vector<Point> to_unit(const Domain& domain, const std::vector<Point>& sites) {
    const Box& box = domain.bounds();
    const double side = std::max(box.width(), box.height());
    std::vector<Point> positions;
    for (const Point p : sites) positions.push_back(1 / side * (p - box.min));
    return positions;
}

}  // namespace

double noise(const Domain& domain, const std::vector<Point>& sites, double blur) {
    constexpr double kCells = 4;  // cells per spacing; each site is divided among the four cells around it
    const Point sides = domain.unit_bounds().max;
    const double cell = std::sqrt(domain.unit_area() / static_cast<double>(sites.size())) / kCells;
    const auto cells = [&](double side) { return static_cast<std::size_t>(std::ceil(side / cell)); };
    Raster land{cells(sides.x), cells(sides.y), {}};
    const Point size{static_cast<double>(land.columns) * cell, static_cast<double>(land.rows) * cell};
    std::vector<BorderEdge> border;
    for (const Ring& ring : domain.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i) border.push_back({ring[i], ring[(i + 1) % ring.size()]});
    }
    land.values = coverage(border, size, static_cast<int>(land.columns), static_cast<int>(land.rows));
    Raster found{land.columns, land.rows, std::vector<double>(land.values.size(), 0)};
    for (const Point p : to_unit(domain, sites)) {
        const auto share = [&](double position, std::size_t count) {
            const double at = std::clamp(position / cell - 0.5, 0.0, static_cast<double>(count - 1));
            const auto before = std::min(static_cast<std::size_t>(at), count - 2);
            return std::pair{before, at - static_cast<double>(before)};
        };
        const auto [i, x] = share(p.x, found.columns);
        const auto [j, y] = share(p.y, found.rows);
        found.at(i, j) += (1 - x) * (1 - y);
        found.at(i + 1, j) += x * (1 - y);
        found.at(i, j + 1) += (1 - x) * y;
        found.at(i + 1, j + 1) += x * y;
    }
    const double sigma = blur * kCells, wanted = 1 / (kCells * kCells);
    const Raster filled = blurred(land, sigma), narrow = blurred(land, sigma / std::numbers::sqrt2);
    found = blurred(std::move(found), sigma);
    double error = 0, random = 0;
    for (std::size_t k = 0; k < found.values.size(); ++k) {
        if (filled.values[k] < 0.9 || land.values[k] < 0.5) continue;
        error += std::pow(found.values[k] - wanted * filled.values[k], 2);
        random += wanted * narrow.values[k] / (4 * std::numbers::pi * sigma * sigma);
    }
    return 10 * std::log10(error / random);
}

std::vector<double> sorted_distances(const Domain& domain, const std::vector<Point>& sites) {
    constexpr double kReach = 8;
    const auto positions = to_unit(domain, sites);
    const double unit = hexagonal_spacing(static_cast<double>(sites.size()) / domain.unit_area());
    const CellList cells(domain, positions);
    std::vector<double> distances;
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        double nearest = kReach;
        cells.for_near(positions[i], kReach * unit, [&](Point position, std::uint32_t number) {
            const Point apart = position - positions[i];
            if (number != i) nearest = std::min(nearest, std::sqrt(dot(apart, apart)) / unit);
        });
        distances.push_back(nearest);
    }
    std::ranges::sort(distances);
    return distances;
}

}  // namespace ccdt::test
