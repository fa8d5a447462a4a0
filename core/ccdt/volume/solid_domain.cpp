// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/solid_domain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "core/geometry/axes.h"

namespace ccdt {

namespace {

constexpr std::int8_t kFar = 16;  ///< largest distance that is stored, in cells
constexpr int kHalvings = 40;     ///< largest number of halvings of a move

}  // namespace

std::size_t SolidDomain::Depths::index(Point3 p) const {
    std::array<std::size_t, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double last = static_cast<double>(cells[axis]) - 3;  // without the margin
        at[axis] = static_cast<std::size_t>(std::clamp(along(p, axis) * along(per_length, axis), 0.0, last)) + 1;
    }
    return (at[2] * cells[1] + at[1]) * cells[0] + at[0];
}

SolidDomain::SolidDomain(const Solid& solid, const Solid::Coverage& coverage) : sides(solid.sides()), solid_(&solid) {
    auto depths = std::make_shared<Depths>();
    const auto [columns, rows, layers] = coverage.cells;
    depths->cell = sides.x + sides.y + sides.z;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double side = along(sides, axis), cells = static_cast<double>(coverage.cells[axis]);
        depths->cells[axis] = coverage.cells[axis] + 2;
        along(depths->per_length, axis) = cells / side;
        depths->cell = std::min(depths->cell, side / cells);
    }
    std::vector<std::int8_t>& grid = depths->grid;
    const std::size_t row = columns + 2, layer = row * (rows + 2);
    grid.assign(layer * (layers + 2), kFar);
    const auto for_cells = [&, columns = columns, rows = rows, layers = layers](auto&& function) {
        for (std::size_t z = 0, number = 0; z < layers; ++z) {
            for (std::size_t y = 0; y < rows; ++y) {
                for (std::size_t x = 0; x < columns; ++x, ++number)
                    function((z + 1) * layer + (y + 1) * row + x + 1, number);
            }
        }
    };
    for_cells([&](std::size_t at, std::size_t number) {
        if (coverage.crossed[number]) grid[at] = 0;
    });
    // Index offsets of a cell's 13 neighbours that come before it in the order of the grid. The second pass runs in
    // reverse order and uses the 13 neighbours that come after it.
    std::array<std::size_t, 13> before{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3 && count < before.size(); ++i)
                before[count++] = (layer + row + 1) - (k * layer + j * row + i);
        }
    }
    const auto nearer = [&](std::size_t at, auto&& neighbour) {
        for (const std::size_t offset : before)
            grid[at] = static_cast<std::int8_t>(std::min<int>(grid[at], grid[neighbour(at, offset)] + 1));
    };
    for_cells([&](std::size_t at, std::size_t) { nearer(at, std::minus<std::size_t>()); });
    for_cells([&](std::size_t at, std::size_t) { nearer(grid.size() - 1 - at, std::plus<std::size_t>()); });
    for_cells([&](std::size_t at, std::size_t number) {
        if (coverage.shares[number] < 0.5) grid[at] = static_cast<std::int8_t>(-grid[at]);
    });
    depths_ = std::move(depths);
}

std::optional<Point3> SolidDomain::foot_within(Point3 p, double distance) const {
    const double clearance = (std::abs(depths_->grid[depths_->index(p)]) - 1) * depths_->cell;
    if (clearance > distance) return std::nullopt;
    const auto near = surface().nearest_within(p, distance);
    if (!near) return std::nullopt;
    return surface().position(*near);
}

bool SolidDomain::contains(Point3 p) const {
    if (in_box(p) != p) return false;
    const std::int8_t depth = depths_->grid[depths_->index(p)];
    return depth != 0 ? depth > 0 : solid_->holds(p);
}

Point3 SolidDomain::in_box(Point3 p) const {
    return {std::clamp(p.x, 0.0, sides.x), std::clamp(p.y, 0.0, sides.y), std::clamp(p.z, 0.0, sides.z)};
}

Point3 SolidDomain::moved(Point3 from, Point3 to) const {
    if (contains(to)) return to;
    if (const Point3 image = 2 * foot(to) - to; contains(image)) return image;
    for (int i = 0; i < kHalvings; ++i) {
        to = 0.5 * (from + to);
        if (contains(to)) return to;
    }
    return from;
}

}  // namespace ccdt
