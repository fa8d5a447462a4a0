// SPDX-License-Identifier: GPL-3.0-or-later
#include "ccdt/volume.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/ccdt/volume/distribute_solid.h"
#include "core/ccdt/volume/distribute_volume.h"
#include "core/ccdt/volume/solid.h"
#include "core/library/conversion.h"
#include "core/points/order/progressive_order.h"
#include "core/points/order/reorder.h"

namespace ccdt::v2 {
namespace {

ccdt::VoxelDensity density_of(const std::optional<VoxelGrid>& grid) {
    if (!grid) return ccdt::VoxelDensity::uniform();
    return value_of(ccdt::VoxelDensity::create({grid->width, grid->height, grid->depth}, grid->values));
}

ccdt::TriangleSoup soup_of(const Solid& solid) {
    ccdt::TriangleSoup soup;
    soup.vertices = converted<ccdt::Point3>(solid.vertices);
    soup.triangles = solid.triangles;
    const auto check = [](bool valid, const char* what, const char* list, std::size_t i) {
        if (!valid) raise(FailureCode::Malformed, what, list + std::to_string(i));
    };
    for (std::size_t i = 0; i < soup.vertices.size(); ++i) {
        const auto [x, y, z] = soup.vertices[i];
        check(std::isfinite(x) && std::isfinite(y) && std::isfinite(z), "a vertex must be finite", "vertices/", i);
    }
    for (std::size_t i = 0; i < soup.triangles.size(); ++i)
        check(std::ranges::max(soup.triangles[i]) < soup.vertices.size(), "a triangle must have indices of vertices",
              "triangles/", i);
    return soup;
}

/// Distributes and orders points in each alternative of VolumeDomain.
struct Distributor {
    const ccdt::VoxelDensity& density;
    const ccdt::VolumeOptions& options;
    bool progressive;
    Execution& execution;

    ccdt::VolumeDistribution operator()(const Box3& box) const {
        return in_box({{box.width, box.height, box.depth}, false});
    }
    ccdt::VolumeDistribution operator()(const Torus3& torus) const {
        return in_box({{torus.width, torus.height, torus.depth}, true});
    }
    ccdt::VolumeDistribution operator()(const Solid& given) const {
        const std::stop_token& stop = execution.control().stop;
        auto surface = value_of(ccdt::Surface::create(soup_of(given), ccdt::Solid::kCrease, stop)).surface;
        const auto solid = value_of(ccdt::Solid::create(std::move(surface), stop));
        auto placed = value_of(ccdt::distribute_in_solid(solid, density, options, execution.control()));
        return ordered(std::move(placed), solid.bounds(), false, std::min(1.0, solid.share()));
    }

private:
    ccdt::VolumeDistribution in_box(const ccdt::BoxDomain3& box) const {
        auto placed = value_of(ccdt::distribute_in_volume(box, density, options, execution.control()));
        return ordered(std::move(placed), {{}, box.sides}, box.periodic, 1);
    }

    ccdt::VolumeDistribution ordered(ccdt::VolumeDistribution placed, const ccdt::Box3& box, bool is_torus,
                                     double share) const {
        if (!progressive) return placed;
        const bool uniform = density.is_uniform() && options.fixed.empty();
        reorder(placed, progressive_order_in_space(box, is_torus, placed.points, share, uniform,
                                                   execution.control().stop, execution.executor()));
        placed.stopped = placed.stopped || execution.control().stop.stop_requested();
        return placed;
    }
};

}  // namespace

VolumeSample sample_volume(const VolumeDomain& domain, std::size_t sites, const VolumeOptions& options,
                           const Control& control) {
    Execution execution(control);
    constexpr double kMaxSeed = 9007199254740991;  // 2^53 - 1
    check_range(static_cast<double>(options.seed), 0, kMaxSeed, "seed");
    const auto density = density_of(options.density);
    const ccdt::VolumeOptions run{.sites = sites,
                                  .seed = options.seed,
                                  .quality = core_quality(options.quality),
                                  .keep_mesh = options.keep_tetrahedra,
                                  .fixed = converted<ccdt::Point3>(options.fixed)};
    auto placed = std::visit(Distributor{density, run, options.progressive, execution}, domain);
    if (placed.stopped && !options.partial) execution.check_stop();
    VolumeSample result{converted<Point3>(placed.points), std::move(placed.trace), placed.stopped, {}};
    if (placed.mesh) result.tetrahedra = {converted<Point3>(placed.mesh->vertices), std::move(placed.mesh->tetrahedra)};
    return result;
}

}  // namespace ccdt::v2
