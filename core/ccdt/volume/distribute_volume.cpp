// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/distribute_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/ccdt/volume/fixed_point_error.h"

namespace ccdt {

namespace {

/// Smallest side of a domain. Coordinates in a smaller domain have too few different values.
constexpr double kShortest = 1e-300;

bool is_length(double v) {
    return std::isfinite(v) && v >= kShortest;
}

}  // namespace

Point3 unit_sides(Point3 sides, std::size_t points) {
    std::array<double*, 3> ascending{&sides.x, &sides.y, &sides.z};
    std::ranges::sort(ascending, {}, [](const double* side) { return *side; });
    const auto [shortest, middle, longest] = ascending;
    const double scale = *longest, share = 1 / static_cast<double>(points);
    for (double* side : ascending) *side /= scale;
    *middle = std::max(*middle, share);
    *shortest = std::max(*shortest, std::sqrt(*middle * share));
    return sides;
}

Result<void> check_volume(const BoxDomain3& domain, const VolumeOptions& options) {
    if (auto checked = check_sites(options); !checked) return checked;
    const Point3 sides = domain.sides;
    if (!is_length(sides.x) || !is_length(sides.y) || !is_length(sides.z))
        return failure(ErrorCode::Malformed, "the sides must be finite and at least 1e-300", "domain");
    for (std::size_t i = 0; i < options.fixed.size(); ++i) {
        const Point3 p = options.fixed[i];
        const auto within = [](double v, double side) { return v >= 0 && v <= side; };
        if (!within(p.x, sides.x) || !within(p.y, sides.y) || !within(p.z, sides.z))
            return tl::unexpected(fixed_point_error(i, p, "in the domain"));
    }
    return {};
}

Result<VolumeDistribution> distribute_in_volume(const BoxDomain3& domain, const VoxelDensity& density,
                                                const VolumeOptions& options, const Control& control) {
    if (auto checked = check_volume(domain, options); !checked) return tl::unexpected(checked.error());
    const Point3 sides = domain.sides;
    const BoxDomain3 unit{unit_sides(sides, options.sites + options.fixed.size()), domain.periodic};
    const double longest = std::max({sides.x, sides.y, sides.z});
    const auto factor = [&](double side, double unit_side) {
        return side / longest == unit_side ? longest : side / unit_side;
    };
    const Point3 scale{factor(sides.x, unit.sides.x), factor(sides.y, unit.sides.y), factor(sides.z, unit.sides.z)};
    const auto scaled = [&](Point3 p) { return Point3{scale.x * p.x, scale.y * p.y, scale.z * p.z}; };
    std::vector<Point3> fixed;
    for (const Point3 p : options.fixed) fixed.push_back(unit.inside({p.x / scale.x, p.y / scale.y, p.z / scale.z}));

    auto result = construct_volume(unit, density, std::nullopt, options, fixed, control);
    if (!result) return result;
    if (result->mesh) {
        for (Point3& vertex : result->mesh->vertices) vertex = scaled(vertex);
    }
    for (Point3& p : result->points) p = domain.inside(scaled(p));
    return result;
}

}  // namespace ccdt
