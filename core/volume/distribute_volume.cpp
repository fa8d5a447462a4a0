// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/volume/distribute_volume.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/volume/fixed_point_error.h"

namespace ccdt {

namespace {

constexpr double kThinnest = 0.25;  ///< least side of a domain, in spacings

bool is_length(double v) {
    return std::isfinite(v) && v > 0;
}

/// Returns the domain, scaled such that its longest side is 1.
BoxDomain3 scaled(const BoxDomain3& domain, double longest) {
    const auto [x, y, z] = domain.sides;
    return {{x / longest, y / longest, z / longest}, domain.periodic};
}

double longest_side(const BoxDomain3& domain) {
    return std::max({domain.sides.x, domain.sides.y, domain.sides.z});
}

}  // namespace

Result<void> check_volume(const BoxDomain3& domain, const VolumeOptions& options) {
    if (auto checked = check_sites(options); !checked) return checked;
    const Point3 sides = domain.sides;
    if (!is_length(sides.x) || !is_length(sides.y) || !is_length(sides.z))
        return failure(ErrorCode::Malformed, "the sides must be finite and > 0", "domain");
    for (std::size_t i = 0; i < options.fixed.size(); ++i) {
        const Point3 p = options.fixed[i];
        const auto within = [](double v, double side) { return v >= 0 && v <= side; };
        if (!within(p.x, sides.x) || !within(p.y, sides.y) || !within(p.z, sides.z))
            return tl::unexpected(fixed_point_error(i, p, "in the domain"));
    }
    const BoxDomain3 unit = scaled(domain, longest_side(domain));
    const double spacing = std::cbrt(unit.volume() / static_cast<double>(options.sites + options.fixed.size()));
    if (spacing > 0 && std::min({unit.sides.x, unit.sides.y, unit.sides.z}) >= kThinnest * spacing) return {};
    return failure(ErrorCode::Unusable, "a side is shorter than a quarter of the mean distance between points",
                   "domain");
}

Result<VolumeDistribution> distribute_in_volume(const BoxDomain3& domain, const VoxelDensity& density,
                                                const VolumeOptions& options, const Control& control) {
    if (auto checked = check_volume(domain, options); !checked) return tl::unexpected(checked.error());
    const double scale = longest_side(domain);
    const BoxDomain3 unit = scaled(domain, scale);
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
