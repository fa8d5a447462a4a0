// SPDX-License-Identifier: GPL-3.0-or-later
#include "ccdt/sample.h"

#include <string>
#include <utility>

#include "core/density/density.h"
#include "core/library/conversion.h"
#include "core/points/order/progressive_order.h"

namespace ccdt::v2 {
namespace {

ccdt::Density density_of(const std::optional<DensityGrid>& grid) {
    if (!grid) return ccdt::Density::uniform();
    return value_of(ccdt::Density::grid(grid->width, grid->height, std::span<const double>(grid->values)), "density/");
}

Triangulation triangulation_of(ccdt::TriangleMesh mesh) {
    return {points_of(mesh.vertices), std::move(mesh.triangles), std::move(mesh.boundary)};
}

void check_inside(const ccdt::Box& box, std::span<const ccdt::Point> points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto [x, y] = points[i];
        if (x >= box.min.x && x <= box.max.x && y >= box.min.y && y <= box.max.y) continue;
        raise(FailureCode::Unusable, "point " + std::to_string(i) + " lies outside the bounding box of the domain",
              "points/" + std::to_string(i));
    }
}

}  // namespace

Sample sample(const Domain& domain, std::size_t sites, const SampleOptions& options, const Control& control) {
    Execution execution(control);
    const auto made = make_domain(domain, options.repair, control.stop);
    ccdt::Options run;
    run.sites = sites;
    run.seed = options.seed;
    run.iterations = options.iterations;
    run.passes = options.passes;
    run.tolerance = options.tolerance;
    run.quality = core_quality(options.quality);
    run.keep_mesh = options.keep_triangulation;
    run.fixed = core_points(options.fixed, "fixed");
    auto placed = value_of(ccdt::distribute(made.domain, density_of(options.density), run, execution.control()));
    if (placed.stopped && !options.partial) execution.check_stop();
    Sample result;
    result.points = points_of(placed.points);
    result.variation = placed.variation();
    result.trace = std::move(placed.trace);
    result.stopped = placed.stopped;
    for (const auto& repair : made.repairs) result.repairs.push_back(repair.detail);
    if (placed.mesh) result.triangulation = triangulation_of(*std::move(placed.mesh));
    return result;
}

std::vector<std::uint32_t> progressive_order(const Domain& domain, std::span<const Point> points, bool uniform,
                                             const Control& control) {
    Execution execution(control);
    const auto made = make_domain(domain, true, control.stop).domain;
    const auto given = core_points(points, "points");
    check_inside(made.bounds(), given);
    auto order = ccdt::progressive_order(made, given, uniform, control.stop, execution.executor());
    execution.check_stop();
    return order;
}

}  // namespace ccdt::v2
