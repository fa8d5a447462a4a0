// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/volume_sample.h"

#include <utility>

#include "api/output/stage_costs.h"
#include "api/run/stopwatch.h"

namespace ccdt::api {

Result<PlacedVolume> place_volume(const VolumeRequest& request, const Decode& decode, const Control& control,
                                  Timings& timings) {
    const auto located = [&](Error error) { return request.located(std::move(error)); };
    Stopwatch watch;
    const auto density = make_density(request.density, decode, control.stop).map_error(located);
    timings.decode = watch.lap();
    if (!density) return tl::unexpected(density.error());
    auto dots = distribute_in_volume(request.domain, *density, request.run, control).map_error(located);
    timings.optimise = watch.lap();
    if (!dots) return tl::unexpected(std::move(dots.error()));
    if (auto whole = check_whole(dots->stopped, request.on_deadline); !whole) return tl::unexpected(whole.error());
    return PlacedVolume{
        .dots = *std::move(dots),
        .domain = request.domain,
        .quality = request.run.quality,
        .seed = request.run.seed,
        .elapsed = timings.decode + timings.optimise,
    };
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
    constexpr Estimate kDraft{440, 120 * kMicrosecond}, kStandard{440, 100 * kMicrosecond};
    constexpr Estimate kBest{440, 350 * kMicrosecond}, kStealthy{900, 800 * kMicrosecond},
        kMesh{700, 20 * kMicrosecond};
    const VolumeOptions& run = request.run;
    Estimate site = run.quality == Quality::Draft      ? kDraft
                    : run.quality == Quality::Standard ? kStandard
                    : run.quality == Quality::Best     ? kBest
                                                       : kStealthy;
    if (run.keep_mesh) site = site + kMesh;
    const Estimate points = site * static_cast<double>(run.sites + run.fixed.size()) +
                            request.format->per_site * static_cast<double>(run.sites);
    Cost cost = total_cost(voxel_cost(request.density) + points);
    cost.answer = run.sites * request.format->least;
    return cost;
}

std::size_t size_of(const VolumeRequest& request) {
    return request.run.fixed.size() * sizeof(Point3) + bytes_of(request.density);
}

}  // namespace ccdt::api
