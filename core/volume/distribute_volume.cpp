// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/distribute_volume.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

#include "core/volume/fixed_point_error.h"

namespace ccdt {

namespace {

constexpr double kThinnest = 0.25;  ///< least side of a domain, in spacings

/// Smallest side of a domain. Coordinates in a smaller domain have too few different values.
constexpr double kShortest = 1e-300;

/// Writes a number with three digits.
std::string rounded(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general, 3).ptr};
}

bool is_length(double v) {
    return std::isfinite(v) && v >= kShortest;
}

}  // namespace

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
    // The volume could overflow.
    const double volume_root = std::cbrt(sides.x) * std::cbrt(sides.y) * std::cbrt(sides.z);
    const double spacing = volume_root / std::cbrt(static_cast<double>(options.sites + options.fixed.size()));
    const double shortest = std::min({sides.x, sides.y, sides.z});
    if (shortest >= kThinnest * spacing) return {};
    return failure(ErrorCode::Unusable,
                   "the shortest side, " + rounded(shortest) +
                       ", is less than a quarter of the mean distance between points, " + rounded(spacing),
                   "domain");
}

Result<VolumeDistribution> distribute_in_volume(const BoxDomain3& domain, const VoxelDensity& density,
                                                const VolumeOptions& options, const Control& control) {
    if (auto checked = check_volume(domain, options); !checked) return tl::unexpected(checked.error());
    const double scale = std::max({domain.sides.x, domain.sides.y, domain.sides.z});
    const BoxDomain3 unit{{domain.sides.x / scale, domain.sides.y / scale, domain.sides.z / scale}, domain.periodic};
    std::vector<Point3> fixed;
    for (const Point3 p : options.fixed) fixed.push_back(unit.inside({p.x / scale, p.y / scale, p.z / scale}));

    auto result = construct_volume(unit, density, std::nullopt, options, fixed, control);
    if (!result) return result;
    if (result->mesh) {
        for (Point3& vertex : result->mesh->vertices) vertex = scale * vertex;
    }
    for (Point3& p : result->points) p = domain.inside(scale * p);
    return result;
}

}  // namespace ccdt
