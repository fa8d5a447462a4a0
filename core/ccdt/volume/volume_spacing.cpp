// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/volume_spacing.h"

#include <algorithm>
#include <cmath>

#include "core/base/elementary.h"

namespace ccdt {

namespace {

constexpr double kMaxCells = 200;  ///< limit on the cells of the grid along an axis
/// Cells per mean spacing. With fewer cells, points crowd where the density changes within a few local spacings.
constexpr double kCellsPerSpacing = 2.25;
/// A voxel with at least kMany points has the spacing of its own density if that is less than kShort times the side of
/// the cube that holds one point.
constexpr double kMany = 8, kShort = 0.5;
constexpr int kSteps = 48;           ///< largest number of steps towards a side; usually, 5 suffice
constexpr double kTolerance = 1e-3;  ///< largest error of the number of points in a cube

/// Returns the side of the cube around a position that holds one point, as if the part of the cube outside the domain
/// held as many points per volume as the part inside.
double side_at(const BoxDomain3& domain, const VoxelDensity& density, double points, Point3 position) {
    const Point3 sides = domain.sides;
    const auto held = [&](double side) {
        Box3 cube;
        double part = 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double length = along(sides, axis), middle = along(position, axis);
            const double low = std::max(0.0, middle - side / 2), high = std::min(length, middle + side / 2);
            along(cube.min, axis) = low / length;
            along(cube.max, axis) = high / length;
            part *= (high - low) / side;
        }
        return density.mass(cube) * points / part;
    };
    double low = 0, high = elementary::cbrt(domain.volume()), side = high / elementary::cbrt(points);
    for (int step = 0; step < kSteps; ++step) {
        const double number = held(side);
        if (std::abs(number - 1) < kTolerance) return side;
        (number < 1 ? low : high) = side;
        const double guess = number > 0 ? side / elementary::cbrt(number) : high;  // right if the density is uniform
        side = step % 2 == 0 && guess > low && guess < high ? guess : (low + high) / 2;
    }
    return high;
}

}  // namespace

VolumeSpacing::VolumeSpacing(const BoxDomain3& domain, const VoxelDensity& density, std::size_t points,
                             Executor& executor, const std::stop_token& stop)
    : mean_(elementary::cbrt(domain.volume() / static_cast<double>(points))), domain_sides_(domain.sides) {
    if (density.is_uniform()) return;
    const auto cells = [&](double side) {
        return static_cast<std::size_t>(std::clamp(std::ceil(kCellsPerSpacing * side / mean_), 2.0, kMaxCells));
    };
    cells_ = {cells(domain.sides.x), cells(domain.sides.y), cells(domain.sides.z)};
    const auto [columns, rows, layers] = cells_;
    sides_.resize(columns * rows * layers);
    many_ = kMany * density.voxel_count() / static_cast<double>(points);
    if (density.largest() >= many_) crowded_ = &density;
    const auto position = [&](std::size_t cell, std::size_t axis) {
        return (static_cast<double>(cell) + 0.5) / static_cast<double>(cells_[axis]) * along(domain_sides_, axis);
    };
    for_ranges(executor, rows * layers, 1, [&, columns = columns, rows = rows](std::size_t line, std::size_t) {
        for (std::size_t i = 0; i < columns && !stop.stop_requested(); ++i) {
            const Point3 centre{position(i, 0), position(line % rows, 1), position(line / rows, 2)};
            sides_[line * columns + i] =
                static_cast<float>(side_at(domain, density, static_cast<double>(points), centre));
        }
    });
}

double VolumeSpacing::side(Point3 p) const {
    if (is_uniform()) return mean_;
    std::array<std::size_t, 3> first{};
    std::array<double, 3> part{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto cells = static_cast<double>(cells_[axis]);
        const double at = std::clamp(along(p, axis) / along(domain_sides_, axis) * cells - 0.5, 0.0, cells - 1);
        first[axis] = static_cast<std::size_t>(std::min(at, cells - 2));
        part[axis] = at - static_cast<double>(first[axis]);
    }
    const std::size_t row = cells_[0], layer = row * cells_[1];
    const float* corner = &sides_[first[2] * layer + first[1] * row + first[0]];
    const auto line = [&](const float* at) { return at[0] + part[0] * (at[1] - at[0]); };
    const auto face = [&](const float* at) { return line(at) + part[1] * (line(at + row) - line(at)); };
    const double side = face(corner) + part[2] * (face(corner + layer) - face(corner));
    if (crowded_ == nullptr) return side;
    const auto position = by_axis<Point3>(
        [&](std::size_t axis) { return std::clamp(along(p, axis) / along(domain_sides_, axis), 0.0, 1.0); });
    const double density = crowded_->at(position);
    if (density < many_) return side;
    const double own = mean_ / elementary::cbrt(density);
    return own < kShort * side ? own : side;
}

}  // namespace ccdt
