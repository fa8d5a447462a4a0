// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample.h"
#include "api/output/dot_tiles.h"

#include <algorithm>
#include <cassert>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/decode/timed_decode.h"
#include "api/input/degrees.h"
#include "api/output/json_writer.h"
#include "api/output/letters.h"
#include "api/run/stopwatch.h"
#include "api/sample/plane/placement.h"
#include "api/sample/plane/sample_area.h"
#include "api/sample/plane/sample_writer.h"

namespace ccdt::api {
namespace {

/// Adds a warning if coordinates look like degrees but are used as coordinates in a plane. make_area() warns if the
/// reference system is known.
void warn_of_degrees(const SampleRegion& region, SampleArea& area) {
    const auto* polygon = std::get_if<PolygonInput>(&region.domain);
    if (polygon == nullptr || !polygon->is_geojson() || region.is_on_globe() || region.system) return;
    if (const auto detail = warning_of_degrees(area.whole.bounds()))
        area.warnings.push_back({polygon->pointer_to({}), *detail});
}

/// Returns the answer without its body.
Answer head_of(const PointFormat& format, const SampleArea& area, const PlacedPoints& placed) {
    constexpr std::size_t kMaxInHeader = 8;  // repairs in an HTTP header; each takes about 150 characters
    Answer answer;
    answer.media_type = format.file.content_type();
    answer.repeats = format.repeats();
    for (const ClassDots& each : placed.classes) {
        answer.sites += each.dots.points.size();
        answer.partial = answer.partial || each.dots.stopped;
    }
    if (format.file.name == "json") return answer;
    const std::span<const Repair> repairs = area.repairs;
    if (!repairs.empty()) answer.repaired = write_repairs(repairs.first(std::min(repairs.size(), kMaxInHeader)));
    if (!area.warnings.empty()) answer.warnings = write_warnings(area.warnings);
    return answer;
}

/// Checks that points can be written as tiles, if the format is one of tiles. Errors: Unusable.
Result<void> check_tiles(const SampleRequest& request, const PlacedSample& sample, const PointFormat& format) {
    if (!format.is_tiled()) return {};
    const auto& classes = sample.placed.classes;
    const bool are_ranked = std::ranges::all_of(
        classes, [](const ClassDots& each) { return each.dots.ranks.size() == each.dots.points.size(); });
    if (!request.region.is_on_globe() || !are_ranked)
        return failure(ErrorCode::Unusable, "the format pmtiles needs coordinates=lonlat and order=progressive",
                       request.field_of("format"));
    for (const ClassDots& each : classes) {
        const auto far = std::ranges::find_if(each.dots.points, [](Point p) { return std::abs(p.y) > kMaxLatitude; });
        if (far == each.dots.points.end()) continue;
        return failure(ErrorCode::Unusable,
                       "there are points beyond the latitude " + std::to_string(kMaxLatitude) +
                           ", where Web Mercator, the projection of tiles, ends",
                       request.field_of("format"));
    }
    return {};
}

}  // namespace

Result<PlacedSample> place_sample(const SampleRequest& request, const Limits& limits, const Decode& decode,
                                  const Control& control, Timings& timings) {
    assert(!request.threshold_mask);
    Stopwatch watch;
    const Decode timed_decode = timed(decode, timings.decode);
    auto area = make_area(request, limits, timed_decode, control.stop);
    if (!area) return tl::unexpected(area.error());
    const PointFormat& format = *request.output.format;
    const auto page = plan_page(request, format, plan_drawing(request, format, *area), limits);
    if (!page) return tl::unexpected(page.error());
    const auto density = make_density(request.density, YAxis::Up, limits, timed_decode, control);
    timings.prepare = watch.lap() - timings.decode;
    if (!density) return tl::unexpected(density.error());

    auto placed = place_points(request, *area, *density, control);
    timings.optimise = watch.lap();
    if (!placed) return tl::unexpected(placed.error());
    if (auto warned = warn_of_lost(request, placed->lost, *area); !warned) return tl::unexpected(warned.error());
    warn_of_degrees(request.region, *area);
    return PlacedSample{*std::move(area), *std::move(placed), timings.before_encoding()};
}

Result<Answer> write_answer(const SampleRequest& request, const PlacedSample& sample, const PointFormat& format,
                            const Limits& limits, const Control& control, Timings& timings, BodySink* sink) {
    Stopwatch watch;
    const auto& [area, placed, elapsed] = sample;
    if (&format != request.output.format) {
        if (auto can = request.about_option(format.check_drawing(request.output.drawing)); !can)
            return tl::unexpected(can.error());
    }
    if (auto can = check_tiles(request, sample, format); !can) return tl::unexpected(can.error());
    const SampleDrawing drawn = plan_drawing(request, format, area);
    if (drawn.figure && !drawn.figure->legend.empty() && format.file.name != kSvg.name && !can_letter())
        return failure(ErrorCode::NotAcceptable, "WebAssembly draws legends only as svg", request.field_of("legend"));
    const auto page = plan_page(request, format, drawn, limits);
    if (!page) return tl::unexpected(page.error());
    std::vector<ClassDots> projected;
    if (drawn.projection) {
        projected = placed.classes;
        for (ClassDots& each : projected) each.dots.points = drawn.place(std::move(each.dots.points));
    }
    const Report report{request.run.seed, elapsed,     {}, request.method->name, area.repairs, {},
                        area.warnings,    placed.pitch};
    Answer answer = head_of(format, area, placed);
    answer.media_type = format.media_type(request.output.drawing);
    Body body(answer, sink, control.stop);
    auto written = write_sample(request, format, drawn, *page, projected.empty() ? placed.classes : projected, report,
                                control, body);
    timings.encode = watch.lap();
    if (!written) return tl::unexpected(written.error());
    return body.finish(std::move(answer));
}

Result<Answer> run_sample(const SampleRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodySink* sink) {
    const auto placed = place_sample(request, limits, decode, control, timings);
    if (!placed) return tl::unexpected(placed.error());
    return write_answer(request, *placed, *request.output.format, limits, control, timings, sink);
}

}  // namespace ccdt::api
