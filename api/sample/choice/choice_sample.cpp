// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/choice/choice_sample.h"

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "api/input/option_reader.h"
#include "api/output/json_writer.h"
#include "api/output/stage_costs.h"
#include "api/run/stopwatch.h"
#include "api/sample/choice/choice_formats.h"
#include "core/base/elementary.h"
#include "core/ccdt/globe/chart.h"
#include "core/points/choice/choice.h"

namespace ccdt::api {
namespace {

/// Returns the spacing in the coordinates in which candidates are chosen: on the globe, those of the unit sphere.
double chord_of(const ChoiceRequest& request) {
    constexpr double kEarthRadius = 6'371'008.8;  // mean radius, metres
    if (!request.is_on_globe) return *request.spacing;
    return 2 * elementary::sin(std::min(*request.spacing / kEarthRadius / 2, std::numbers::pi / 2));
}

/// Returns the density at each candidate. The map is stretched over their bounding box.
std::vector<double> densities_at(const std::vector<Point3>& candidates, const Density& density) {
    if (candidates.empty()) return {};
    const Box3 box = bounds_of(candidates);
    const auto cell = [](double at, double low, double high, int cells) {
        const double share = high > low ? (at / 2 - low / 2) / (high / 2 - low / 2) : 0;
        return std::min(static_cast<int>(share * cells), cells - 1);
    };
    std::vector<double> densities;
    for (const Point3 p : candidates)
        densities.push_back(density.value(cell(p.x, box.min.x, box.max.x, density.width()),
                                          cell(p.y, box.min.y, box.max.y, density.height())));
    return densities;
}

/// Converts an error of core, whose field is a member of the request, to one about an option beside a file.
Error error_of(const ChoiceRequest& request, Error error) {
    if (!request.is_file) return error_below(std::move(error), "");
    error.field = error.field.substr(0, error.field.find('/'));
    return error;
}

}  // namespace

Result<Answer> run_choice(const ChoiceRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodySink* sink) {
    Stopwatch watch;
    std::vector<double> densities;
    if (request.density_map.index() > 0) {
        auto density = make_density(request.density_map, YAxis::Up, limits, decode, control);
        if (!density) return tl::unexpected(density.error());
        densities = densities_at(request.candidates, *density);
        timings.decode = watch.lap();
    }
    std::vector<Point3> directions;
    if (request.is_on_globe) {
        for (const Point3 p : request.candidates) {
            const Direction d = direction_of({p.x, p.y});
            directions.push_back({d.x, d.y, d.z});
        }
    }
    const Candidates candidates{.positions = request.is_on_globe ? directions : request.candidates,
                                .extent = request.extent,
                                .density = densities.empty() ? request.density : densities,
                                .priority = request.priority,
                                .kept = request.kept,
                                .classes = request.classes,
                                .counts = request.counts,
                                .torus = {}};
    timings.prepare = watch.lap();
    auto chosen = request.spacing
                      ? choose_apart(candidates, chord_of(request), control.stop)
                      : choose_points(candidates, request.sites, request.seed, control.stop, *control.executor);
    if (chosen && request.is_progressive && !control.stop.stop_requested()) {
        auto order = order_choice(candidates, chosen->rows, control.stop, *control.executor);
        if (!control.stop.stop_requested()) chosen->rows = std::move(order);
    }
    timings.optimise = watch.lap();
    if (!chosen) return tl::unexpected(error_of(request, chosen.error()));

    Answer answer;
    answer.partial = control.stop.stop_requested();
    if (auto whole = check_whole(answer.partial, request.on_deadline); !whole) return tl::unexpected(whole.error());
    answer.media_type = request.format->file.content_type();
    answer.sites = chosen->rows.size();
    if (request.format->file.name != kJson.name) {
        std::vector<Warning> warnings = request.warnings;
        if (chosen->shortfall > 0)
            warnings.push_back({"sites", std::to_string(chosen->shortfall) +
                                             " points are wanted where there are too few candidates; they are chosen "
                                             "elsewhere"});
        if (!warnings.empty()) answer.warnings = write_warnings(warnings);
    }
    Body body(answer, sink, stop_of_writing(control, request.on_deadline));
    request.format->write(request, *chosen, answer.partial, body);
    timings.encode = watch.lap();
    return body.finish(std::move(answer));
}

Cost cost_of(const ChoiceRequest& request) {
    // Measured: 1 million candidates with 100,000 sites, and 20,480 with 4,096. A site is visited 20 to 200 times.
    constexpr Estimate kCandidate{250, 2 * kMicrosecond}, kVisit{0, 1.2 * kMicrosecond};
    // With a spacing, all candidates may be chosen.
    const auto sites = static_cast<double>(request.spacing ? request.candidates.size() : request.sites),
               candidates = static_cast<double>(request.candidates.size());
    // With classes, each of them is searched three times.
    const double rounds = request.classes.empty() ? 1 : 3;
    const double visits = rounds * std::min(200 * sites, std::max(2e6, 20 * sites));
    // Progressive orders take about as long as visits. An answer of records is at most as large as the file.
    const double order = request.is_progressive ? 20 * sites : 0;
    const double answer =
        request.format->has_records ? static_cast<double>(request.file.size()) : sites * request.format->bytes_per_site;
    return total_cost(decoding_cost(request.density_map) + kCandidate * candidates + kVisit * (visits + order) +
                      Estimate{answer, 0});
}

std::size_t size_of(const ChoiceRequest& request) {
    return request.candidates.size() * sizeof(Point3) + request.kept.size() + request.file.size() +
           request.table.records.size() * sizeof(TextRange) + request.table.rows.size() * sizeof(std::uint32_t) +
           request.classes.size() * sizeof(std::uint32_t) + bytes_of(request.density_map) +
           (request.density.size() + request.priority.size()) * sizeof(double);
}

}  // namespace ccdt::api
