// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/sample.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/input/degrees.h"
#include "api/output/json_writer.h"
#include "api/run/stopwatch.h"
#include "api/sample/placement.h"
#include "api/sample/sample_area.h"
#include "api/sample/sample_writer.h"
#include "core/density/density.h"
#include "core/globe/turns.h"
#include "core/halftone/tone.h"

namespace ccdt::api {
namespace {

/// Reverses the order of the rows. Pictures begin with the top row, density grids with the bottom row.
void flip_rows(std::vector<float>& values, int width) {
    const auto row = static_cast<std::ptrdiff_t>(width);
    auto top = values.begin();
    for (auto bottom = values.end() - row; top < bottom; top += row, bottom -= row) {
        std::swap_ranges(top, top + row, bottom);
    }
}

Result<Density> make_density(const DensityImage& image, const Limits& limits, const Decode& decode,
                             const Control& control) {
    auto picture = decode.grey(image.file.bytes, limits.max_pixels, control.stop);
    if (!picture) return failure(picture.error().code, picture.error().message, "/density/image");
    const int width = picture->width;
    const int height = picture->height;
    std::vector<float> coverage = ink_coverage(*picture, Tone::Linear, false);
    *picture = {};  // frees several megabytes per megapixel
    flip_rows(coverage, width);
    auto density = Density::grid(width, height, std::span<const float>(coverage));
    if (!density) density.error().field = "/density/image";
    return density;
}

/// Creates the density of a request. Errors: those of `decode` and of Density::grid, with a JSON Pointer.
Result<Density> make_density(const SampleRequest& request, const Limits& limits, const Decode& decode,
                             const Control& control) {
    if (const auto* image = std::get_if<DensityImage>(&request.density))
        return make_density(*image, limits, decode, control);
    const auto* grid = std::get_if<DensityGrid>(&request.density);
    if (grid == nullptr) return Density::uniform();
    auto density = Density::grid(grid->width, grid->height, std::span<const double>(grid->values));
    if (!density) return tl::unexpected(error_below(density.error(), "/density"));
    return density;
}

/// Shifts the longitudes of points, which are from -180 to 180 degrees, by multiples of 360 degrees, so that the points
/// lie in the box that is drawn.
void shift_into(const Box& box, std::vector<Point>& points) {
    if (box.min.x >= -kTurn / 2 && box.max.x <= kTurn / 2) return;
    for (Point& p : points) p.x += longitude_wrap_offset(p.x, box.min.x);
}

/// Adds a warning if coordinates look like degrees but are used as coordinates in a plane.
void warn_of_degrees(const SampleRegion& region, SampleArea& area) {
    const auto* polygon = std::get_if<PolygonInput>(&region.domain);
    if (polygon == nullptr || !polygon->is_geojson() || region.is_on_globe()) return;
    if (const auto detail = warning_of_degrees(area.whole.bounds()))
        area.warnings.push_back({polygon->locate({}), *detail});
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

}  // namespace

Result<Answer> run_sample(const SampleRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodySink* sink) {
    if (request.threshold_mask) return run_mask(*request.threshold_mask, control, timings);
    Stopwatch watch;
    auto area = make_area(request, limits, decode, control.stop);
    if (!area) return tl::unexpected(area.error());
    const auto page = plan_page(request, area->whole, limits);
    if (!page) return tl::unexpected(page.error());
    const auto density = make_density(request, limits, decode, control);
    timings.decode = watch.lap();
    if (!density) return tl::unexpected(density.error());

    auto placed = place_points(request, *area, *density, control);
    timings.optimise = watch.lap();
    if (!placed) return tl::unexpected(placed.error());
    if (auto warned = warn_of_lost(request, placed->lost, *area); !warned) return tl::unexpected(warned.error());
    warn_of_degrees(request.region, *area);

    const PointFormat& format = *request.output.format;
    if (format.is_drawn() && placed->pitch) {
        for (ClassDots& each : placed->classes) shift_into(page->box, each.dots.points);
    }
    const double elapsed = timings.decode + timings.optimise;
    const Report report{request.run.seed, elapsed,      {}, request.method->name, area->repairs, {},
                        area->warnings,   placed->pitch};
    Answer answer = head_of(format, *area, *placed);
    Body body(answer, sink, control.stop);
    auto written = write_sample(request, area->whole, *page, placed->classes, report, control, body);
    timings.encode = watch.lap();
    if (!written) return tl::unexpected(written.error());
    return body.finish(std::move(answer));
}

}  // namespace ccdt::api
