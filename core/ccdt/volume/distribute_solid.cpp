// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/distribute_solid.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "core/ccdt/volume/fixed_point_error.h"
#include "core/ccdt/volume/solid_domain.h"

namespace ccdt {

namespace {

// Numbers of cells of the grid by which the solid is measured.
constexpr double kCellsPerSite = 8, kMinCells = 1 << 17;

/// Returns the mean density in each cell of a grid, relative to the mean over the bounding box. The density outside the
/// solid counts as 0.
std::vector<double> densities_inside(Solid::Coverage coverage, const VoxelDensity& density) {
    std::vector<double> values = std::move(coverage.shares);
    if (density.is_uniform()) return values;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (values[i] > 0) values[i] *= density.mass(cell_box(coverage.cells, i)) * static_cast<double>(values.size());
    }
    return values;
}

/// A solid as a domain, and the density, which is 0 outside the solid.
struct Inside {
    SolidDomain domain;
    VoxelDensity density;
};

Result<Inside> measure(const Solid& solid, const VoxelDensity& density, double cells, const std::stop_token& stop) {
    Solid::Coverage coverage = solid.coverage(cells, stop);
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    SolidDomain domain(solid, coverage);
    const auto grid = coverage.cells;
    const std::vector<double> values = densities_inside(std::move(coverage), density);
    const Point3 sides = domain.sides;
    domain.set_volume(std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()) *
                      sides.x * sides.y * sides.z);
    auto inside = VoxelDensity::create(grid, values);
    if (!inside) return failure(ErrorCode::Unusable, "the density is 0 everywhere in the solid", "density");
    return Inside{std::move(domain), std::move(*inside)};
}

}  // namespace

Result<VolumeDistribution> distribute_in_solid(const Solid& solid, const VoxelDensity& density,
                                               const VolumeOptions& options, const Control& control) {
    if (auto checked = check_sites(options); !checked) return tl::unexpected(checked.error());
    const Surface& surface = solid.surface();
    std::vector<Point3> fixed;
    for (std::size_t i = 0; i < options.fixed.size(); ++i) {
        if (!solid.contains(options.fixed[i]))
            return tl::unexpected(fixed_point_error(i, options.fixed[i], "inside the solid"));
        fixed.push_back(surface.from_input(options.fixed[i]));
    }
    const auto points = static_cast<double>(options.sites + fixed.size());
    auto inside = measure(solid, density, std::max(kMinCells, kCellsPerSite * points), control.stop);
    if (!inside) return tl::unexpected(inside.error());
    auto result = construct_volume(inside->domain, density, std::move(inside->density), options, fixed, control);
    if (!result) return result;
    for (Point3& p : result->points) p = surface.to_input(p);
    if (result->mesh) {
        for (Point3& p : result->mesh->vertices) p = surface.to_input(p);
    }
    return result;
}

}  // namespace ccdt
