// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/voxel_density.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/ccdt/volume/point_text.h"

namespace ccdt {

namespace {

/// Largest density, relative to the largest one, that counts as 0, because sums of densities cannot resolve it.
constexpr double kNegligible = std::numeric_limits<double>::epsilon();

}  // namespace

Result<bool> VoxelDensity::check(const std::array<std::size_t, 3>& voxels,
                                 const std::function<double(std::size_t index)>& value) {
    const auto [columns, rows, layers] = voxels;
    const double first = value(0);
    bool is_zero = true, are_equal = true;
    for (std::size_t i = 0; i < columns * rows * layers; ++i) {
        const double density = value(i);
        is_zero = is_zero && density == 0;
        are_equal = are_equal && density == first;
        if (density >= 0 && std::isfinite(density)) continue;
        return failure(ErrorCode::Malformed,
                       "the density is " + text(density) + " in voxel (" + std::to_string(i % columns) + ", " +
                           std::to_string(i / columns % rows) + ", " + std::to_string(i / columns / rows) +
                           "), but must be finite and at least 0",
                       "density/" + std::to_string(i));
    }
    if (is_zero) return failure(ErrorCode::Unusable, "the density is 0 everywhere", "density");
    return are_equal;
}

Result<VoxelDensity> VoxelDensity::create(const std::array<std::size_t, 3>& voxels, std::span<const double> values) {
    const auto [columns, rows, layers] = voxels;
    // The quotients come first, because the product could overflow.
    if (columns == 0 || rows == 0 || layers == 0 || values.size() / columns / rows != layers ||
        values.size() != columns * rows * layers)
        return failure(ErrorCode::Malformed, "the density must have one value for each voxel", "density");
    const auto are_equal = check(voxels, [values](std::size_t i) { return values[i]; });
    if (!are_equal) return tl::unexpected(are_equal.error());
    if (*are_equal) return uniform();

    const double largest = std::ranges::max(values);
    VoxelDensity density;
    density.voxels_ = voxels;
    std::vector<double>& sums = density.sums_;
    sums.assign((columns + 1) * (rows + 1) * (layers + 1), 0);
    const std::size_t row = columns + 1, layer = row * (rows + 1);
    double squares = 0;
    for (std::size_t k = 0; k < layers; ++k) {
        for (std::size_t j = 0; j < rows; ++j) {
            double line = 0;
            for (std::size_t i = 0; i < columns; ++i) {
                const double value = values[(k * rows + j) * columns + i] / largest;
                line += value;
                squares += value * value;
                double& sum = sums[(k + 1) * layer + (j + 1) * row + i + 1];
                sum = line + (&sum)[-static_cast<std::ptrdiff_t>(row)];
            }
        }
        for (std::size_t i = 0; i < layer; ++i) sums[(k + 1) * layer + i] += sums[k * layer + i];
    }
    const auto is_positive = [largest](double value) { return value / largest > kNegligible; };
    if (!is_positive(std::ranges::min(values))) {
        for (const double value : values) density.positive_.push_back(is_positive(value));
    }
    const double total = sums.back();
    for (double& sum : sums) sum /= total;
    density.largest_ = static_cast<double>(values.size()) / total;
    density.contrast_ = squares / total * (static_cast<double>(values.size()) / total);
    return density;
}

std::size_t VoxelDensity::voxel(double v, std::size_t axis) const {
    const auto count = static_cast<double>(voxels_[axis]);
    return static_cast<std::size_t>(std::clamp(v * count, 0.0, count - 1));
}

VoxelDensity::Position VoxelDensity::position(double v, std::size_t axis) const {
    const std::size_t first = voxel(v, axis);
    return {first, v * static_cast<double>(voxels_[axis]) - static_cast<double>(first)};
}

/// Returns the share of the mass between the origin and a point. The density must not be uniform.
double VoxelDensity::sum(Position x, Position y, Position z) const {
    const std::size_t row = voxels_[0] + 1, layer = row * (voxels_[1] + 1);
    const double* corner = &sums_[z.first * layer + y.first * row + x.first];
    const auto line = [&](const double* at) { return at[0] + x.part * (at[1] - at[0]); };
    const auto face = [&](const double* at) { return line(at) + y.part * (line(at + row) - line(at)); };
    return face(corner) + z.part * (face(corner + layer) - face(corner));
}

double VoxelDensity::mass(const Box3& box) const {
    if (is_uniform()) return (box.max.x - box.min.x) * (box.max.y - box.min.y) * (box.max.z - box.min.z);
    const Position left = position(box.min.x, 0), right = position(box.max.x, 0);
    const Position front = position(box.min.y, 1), back = position(box.max.y, 1);
    const auto face = [&](Position z) {
        return (sum(right, back, z) - sum(left, back, z)) - (sum(right, front, z) - sum(left, front, z));
    };
    return std::max(0.0, face(position(box.max.z, 2)) - face(position(box.min.z, 2)));
}

double VoxelDensity::at(Point3 p) const {
    if (is_uniform()) return 1;
    Box3 box;
    double voxels = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto count = static_cast<double>(voxels_[axis]), first = static_cast<double>(voxel(along(p, axis), axis));
        along(box.min, axis) = first / count;
        along(box.max, axis) = (first + 1) / count;
        voxels *= count;
    }
    return mass(box) * voxels;
}

bool VoxelDensity::is_positive(Point3 p) const {
    return !has_gaps() || positive_[voxel_at(p)];
}

double VoxelDensity::cut(const Box3& box, std::size_t axis, double share) const {
    const double low = along(box.min, axis), high = along(box.max, axis);
    const auto even = low + share * (high - low);
    if (is_uniform()) return even;
    const auto below = [&](double v) {
        Box3 part = box;
        along(part.max, axis) = v;
        return mass(part);
    };
    const double wanted = share * mass(box);
    if (!(wanted > 0)) return even;
    // The mass is linear between the planes where voxels begin.
    const auto count = static_cast<double>(voxels_[axis]);
    double first = low, last = high, first_mass = 0, last_mass = wanted / share;
    std::size_t begin = voxel(low, axis) + 1, end = voxel(high, axis) + 1;
    while (begin < end) {
        const std::size_t middle = begin + (end - begin) / 2;
        const double plane = std::clamp(static_cast<double>(middle) / count, low, high), mass = below(plane);
        if (mass < wanted) {
            first = plane;
            first_mass = mass;
            begin = middle + 1;
        } else {
            last = plane;
            last_mass = mass;
            end = middle;
        }
    }
    const double step = last_mass - first_mass;
    return step > 0 ? first + std::clamp((wanted - first_mass) / step, 0.0, 1.0) * (last - first) : last;
}

Point3 VoxelDensity::draw(Box3 box, const std::array<double, 3>& shares) const {
    Point3 p;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double v = cut(box, axis, shares[axis]);
        along(p, axis) = v;
        if (is_uniform()) continue;
        const auto count = static_cast<double>(voxels_[axis]), first = static_cast<double>(voxel(v, axis));
        along(box.min, axis) = std::max(along(box.min, axis), first / count);
        along(box.max, axis) = std::min(along(box.max, axis), (first + 1) / count);
    }
    return p;
}

Box3 cell_box(const std::array<std::size_t, 3>& cells, std::size_t number) {
    const auto [columns, rows, layers] = cells;
    const Point3 cell{1.0 / static_cast<double>(columns), 1.0 / static_cast<double>(rows),
                      1.0 / static_cast<double>(layers)};
    const auto x = static_cast<double>(number % columns), y = static_cast<double>(number / columns % rows),
               z = static_cast<double>(number / columns / rows);
    return {{x * cell.x, y * cell.y, z * cell.z},
            {std::min(1.0, (x + 1) * cell.x), std::min(1.0, (y + 1) * cell.y), std::min(1.0, (z + 1) * cell.z)}};
}

}  // namespace ccdt
