// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/volume_sample.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include "api/output/stage_costs.h"
#include "api/run/stopwatch.h"
#include "api/sample/ordering.h"
#include "core/order/progressive_order.h"
#include "core/volume/distribute_solid.h"
#include "core/volume/solid.h"

namespace ccdt::api {
namespace {

/// Reads the mesh that bounds a solid.
/// @param placed  receives the notes about the mesh
Result<Solid> make_solid(const SurfaceFile& file, const Decode& decode, const std::stop_token& stop,
                         PlacedVolume& placed) {
    const auto read = decode.surface(file.bytes, file.header, stop);
    if (!read) return tl::unexpected(read.error());
    auto made = Surface::create(read->soup, Solid::kCrease, stop);
    if (!made) return tl::unexpected(made.error());
    placed.repairs = std::move(made->repairs);
    placed.warnings = std::move(made->warnings);
    return Solid::create(std::move(made->surface), stop);
}

/// Puts points into the requested order. After a stop, the order is arbitrary.
/// @param solid  null: the domain is a box or torus
void order_points(const VolumeRequest& request, const Solid* solid, const VoxelDensity& density, const Control& control,
                  VolumeDistribution& dots) {
    if (request.order != PointOrder::Progressive) return;
    const auto& [sides, periodic] = request.domain;
    const bool is_even = solid == nullptr && periodic && density.is_uniform() && request.run.fixed.empty();
    const Box3 box = solid == nullptr ? Box3{{}, sides} : solid->bounds();
    const double share = solid == nullptr ? 1 : std::min(1.0, solid->share());
    set_order(dots,
              progressive_order_in_space(box, solid == nullptr && periodic, dots.points, share, is_even, control.stop,
                                         *control.executor),
              control.stop);
}

}  // namespace

Result<PlacedVolume> place_volume(const VolumeRequest& request, const Decode& decode, const Control& control,
                                  Timings& timings) {
    const auto located = [&](Error error) { return request.located(std::move(error)); };
    PlacedVolume placed{.dots = {}, .domain = request.domain, .quality = request.run.quality, .seed = request.run.seed};
    Stopwatch watch;
    const auto density = make_density(request.density, decode, control.stop).map_error(located);
    if (!density) return tl::unexpected(density.error());
    std::optional<Solid> solid;
    if (request.solid) {
        auto made = make_solid(*request.solid, decode, control.stop, placed);
        if (!made) return tl::unexpected(std::move(made.error()));
        solid = *std::move(made);
    }
    timings.decode = watch.lap();
    auto dots = solid ? distribute_in_solid(*solid, *density, request.run, control)
                      : distribute_in_volume(request.domain, *density, request.run, control);
    if (dots) order_points(request, solid ? &*solid : nullptr, *density, control, *dots);
    timings.optimise = watch.lap();
    if (!dots) return tl::unexpected(located(std::move(dots.error())));
    if (auto whole = check_whole(dots->stopped, request.on_deadline); !whole) return tl::unexpected(whole.error());
    placed.dots = *std::move(dots);
    placed.elapsed = timings.decode + timings.optimise;
    return placed;
}

Result<Answer> write_answer(const VolumeRequest& request, const PlacedVolume& placed, const VolumePointFormat& format,
                            const Control& control, Timings& timings, BodySink* sink) {
    return write_in_space(request, placed, format, control, timings, sink).map_error([&](Error error) {
        return request.located(std::move(error));
    });
}

Result<Answer> run_volume(const VolumeRequest& request, const Decode& decode, const Control& control, Timings& timings,
                          BodySink* sink) {
    const auto placed = place_volume(request, decode, control, timings);
    if (!placed) return tl::unexpected(placed.error());
    return write_answer(request, *placed, *request.format, control, timings, sink);
}

Cost cost_of(const VolumeRequest& request) {
    // Fitted to measured peaks of resident memory and to measured times; tests/api/cost_test.cpp compares the peaks.
    constexpr Estimate kDraft{100, 34 * kMicrosecond}, kStandard{260, 31 * kMicrosecond};
    constexpr Estimate kBest{300, 60 * kMicrosecond}, kStealthy{550, 77 * kMicrosecond};
    constexpr Estimate kUneven{50, 65 * kMicrosecond}, kSolid{250, 65 * kMicrosecond};
    constexpr Estimate kMesh{750, 14 * kMicrosecond}, kProgressive{100, 7 * kMicrosecond};
    constexpr Estimate kTriangle{300, 3.2 * kMicrosecond};           // of a mesh, as for points on its surface
    constexpr double kInBlock = 1'200, kMaxInBlocks = 4.0 * 10'000;  // sites of blocks that are relaxed at a time
    const VolumeOptions& run = request.run;
    Estimate site = run.quality == Quality::Draft      ? kDraft
                    : run.quality == Quality::Standard ? kStandard
                    : run.quality == Quality::Best     ? kBest
                                                       : kStealthy;
    const bool uneven = !std::holds_alternative<std::monostate>(request.density);
    if (request.solid || uneven) site = site + (request.solid ? kSolid : kUneven);
    if (run.keep_mesh) site = site + kMesh;
    if (request.order == PointOrder::Progressive) site = site + kProgressive;
    const auto count = static_cast<double>(run.sites + run.fixed.size());
    const Estimate points = site * count + Estimate{kInBlock * std::min(count, kMaxInBlocks), 0} +
                            request.format->per_site * static_cast<double>(run.sites);
    const SurfaceHeader mesh = request.solid ? request.solid->header : SurfaceHeader{};
    const Estimate read{static_cast<double>(mesh.decoder_bytes), 0};
    Cost cost = total_cost(
        then(read, voxel_cost(request.density) + kTriangle * static_cast<double>(mesh.max_triangles) + points));
    cost.answer = run.sites * request.format->least;
    return cost;
}

std::size_t size_of(const VolumeRequest& request) {
    return request.run.fixed.size() * sizeof(Point3) + bytes_of(request.density);
}

}  // namespace ccdt::api
