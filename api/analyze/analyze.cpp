// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/analyze/analyze.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "api/input/negotiation.h"
#include "api/input/point_reader.h"
#include "api/input/polygon_reader.h"
#include "api/output/json_writer.h"
#include "api/output/spectrum_plot.h"
#include "api/output/stage_costs.h"
#include "api/output/svg_renderer.h"
#include "api/run/stopwatch.h"
#include "core/base/elementary.h"

namespace ccdt::api {
namespace {

constexpr Interval kFrequencies = {.min = 1, .max = 16};
constexpr double kMinShare = 0.001;   // least share of the bounding box that is assumed to be covered by polygons
constexpr double kPixelsPerUnit = 2;  // resolution of a plot as PNG, pixels per user unit

/// A request that is being parsed. Its options have been read, but their combination has not been checked yet.
struct Draft {
    AnalyzeRequest request;
    std::optional<AnySets> points;  ///< one set
    std::optional<AnySets> sets;
    std::optional<std::variant<Rectangle, BoxDomain3>> domain;
    std::optional<Ring> polygon;
    std::optional<std::vector<Ring>> holes;
    std::optional<PolygonInput> geometry;
    std::optional<double> max_frequency;
};

/// Whether the first position of a list has three coordinates.
bool is_in_space(JsonValue list) {
    if (!list.is_array() || list.size() == 0) return false;
    const JsonValue first = *list.begin();
    return first.is_array() && first.size() == 3;
}

Result<void> append_set(const Input& input, const Limits&, PlaneSets& given) {
    return assign(given.sets.emplace_back(), read_ring(input));
}
Result<void> append_set(const Input& input, const Limits& limits, SpaceSets& given) {
    return assign(given.sets.emplace_back(), read_points3(input, limits));
}

/// Reads sets of points. The first set determines whether all are in space.
Result<AnySets> read_lists(std::span<const Input> inputs, const Limits& limits) {
    AnySets sets;
    if (!inputs.empty() && is_in_space(std::get<JsonValue>(inputs.front().value))) sets = SpaceSets();
    for (const Input& input : inputs) {
        auto appended = std::visit([&](auto& given) { return append_set(input, limits, given); }, sets);
        if (!appended) return tl::unexpected(std::move(appended.error()));
    }
    return sets;
}

Result<AnySets> read_sets(const Input& input, const Limits& limits) {
    const auto list = std::get<JsonValue>(input.value);
    if (!list.is_array()) return malformed(input, "must be a list of sets of points");
    std::vector<Input> inputs;
    for (const JsonValue element : list) {
        const std::string pointer = pointer_below(input.field, inputs.size());
        inputs.push_back({pointer, pointer, element});
    }
    return read_lists(inputs, limits);
}

Result<void> read_domain(const Input& input, std::optional<std::variant<Rectangle, BoxDomain3>>& domain) {
    if (is_box(std::get<JsonValue>(input.value))) return assign(domain, read_box(input));
    return assign(domain, read_rectangle(input));
}

constexpr std::array<OptionRule<Draft>, 9> kRules = {{
    {"points",
     [](const Input& i, const Limits& l, Draft& d) {
         return assign(d.points, read_lists({&i, 1}, l));
     }},
    {"sets", [](const Input& i, const Limits& l, Draft& d) { return assign(d.sets, read_sets(i, l)); }},
    {"domain", [](const Input& i, const Limits&, Draft& d) { return read_domain(i, d.domain); }},
    {"polygon", [](const Input& i, const Limits&, Draft& d) { return assign(d.polygon, read_ring(i)); }},
    {"holes", [](const Input& i, const Limits&, Draft& d) { return assign(d.holes, read_rings(i)); }},
    {"geometry", [](const Input& i, const Limits&, Draft& d) { return assign(d.geometry, read_geometry(i)); }},
    {"spectrum", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.spectrum, read_boolean(i)); }},
    {"max_frequency",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.max_frequency, read_number(i, kFrequencies)); }},
    {"format", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.request.format, read_format(i, analyze_formats())); }},
}};

std::size_t count_points(const AnalyzeRequest& request) {
    return std::visit(
        [](const auto& given) {
            std::size_t points = 0;
            for (const auto& set : given.sets) points += set.size();
            return points;
        },
        request.points);
}

Result<void> check_count(const AnalyzeRequest& request, const Limits& limits) {
    const std::size_t points = count_points(request);
    if (points <= limits.max_sites) return {};
    return failure(ErrorCode::LimitExceeded,
                   "there are " + std::to_string(points) + " points; this server's limit (max-sites) is " +
                       std::to_string(limits.max_sites),
                   request.single ? "/points" : "/sets");
}

/// Converts the field of an error of analyse() to a JSON Pointer in the request.
Error located(const AnalyzeRequest& request, Error error) {
    std::string& field = error.field;
    if (error.code == ErrorCode::Stopped) return error;
    if (!field.empty() && field.front() != '/') {
        field = pointer_below("", field);
    } else if (request.single) {
        const auto point = field.find('/', 1);
        field.replace(0, std::min(point, field.size()), "/points");
    } else {
        field.insert(0, "/sets");
    }
    return error;
}

/// Returns the area of a ring, by the shoelace formula.
double area_of(const Ring& ring) {
    double twice = 0;
    for (std::size_t i = 0; i < ring.size(); ++i)
        twice += cross(ring[i] - ring[0], ring[(i + 1) % ring.size()] - ring[0]);
    return std::abs(twice) / 2;
}

Box bounds_of(const std::vector<PolygonPart>& parts) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Box box{{kFar, kFar}, {-kFar, -kFar}};
    for (const PolygonPart& part : parts) {
        for (const Point& corner : part.outer) box.include(corner);
    }
    return box;
}

/// Returns the share of the bounding box that polygons cover if they do not overlap; at least kMinShare.
double share_of_box(const std::vector<PolygonPart>& parts) {
    const Box box = bounds_of(parts);
    double area = 0;
    for (const PolygonPart& part : parts) {
        area += area_of(part.outer);
        for (const Ring& hole : part.holes) area -= area_of(hole);
    }
    const double share = area / (box.width() * box.height());
    return share > kMinShare ? std::min(share, 1.0) : kMinShare;
}

/// Creates the domain of the polygons of a request. Errors: those of Domain::repair(); Unusable for overlaps.
Result<Domain> make_domain(const PolygonInput& polygon, const std::stop_token& stop) {
    auto repaired = Domain::repair(polygon.parts, stop);
    if (!repaired) {
        repaired.error().field = polygon.pointer_to(repaired.error().field);
        return tl::unexpected(std::move(repaired.error()));
    }
    const Point sides = repaired->domain.unit_bounds().max;
    const double covered = repaired->domain.unit_area() / (sides.x * sides.y);
    if (covered < kMinShare / 2)
        return failure(ErrorCode::Unusable, "the polygons cover less than a thousandth of their extent",
                       polygon.pointer_to({}));
    if (covered < share_of_box(polygon.parts) / 2)
        return failure(ErrorCode::Unusable,
                       "the polygons overlap too much: they cover less than half of the sum of their areas",
                       polygon.pointer_to({}));
    return std::move(repaired->domain);
}

/// Analyses sets. Errors: those of the domain and of analyse(), located in the request.
Result<Analysis> analyse_sets(const AnalyzeRequest& request, const PlaneSets& given, const std::stop_token& stop) {
    const auto domain = given.polygon ? make_domain(*given.polygon, stop) : make_domain(given.domain);
    if (!domain) return tl::unexpected(domain.error());
    return analyse(given.sets, *domain, request.options, stop).map_error([&](Error error) {
        if (given.polygon && error.field == "domain") {
            error.field = given.polygon->pointer_to({});
            return error;
        }
        return located(request, std::move(error));
    });
}
Result<Analysis> analyse_sets(const AnalyzeRequest& request, const SpaceSets& given, const std::stop_token& stop) {
    return analyse(given.sets, given.domain.sides, given.domain.periodic, request.options, stop)
        .map_error([&](Error error) { return located(request, std::move(error)); });
}

/// Checks sets as far as it takes little time: not in polygons.
Result<void> check_sets(const AnalyzeRequest& request, const PlaneSets& given) {
    if (given.polygon) return check_size(*given.polygon);
    return make_domain(given.domain).and_then([&](const Domain& domain) {
        return check_analysis(given.sets, domain, request.options).map_error([&](Error error) {
            return located(request, std::move(error));
        });
    });
}
Result<void> check_sets(const AnalyzeRequest& request, const SpaceSets& given) {
    return check_analysis(given.sets, given.domain.sides, given.domain.periodic, request.options)
        .map_error([&](Error error) { return located(request, std::move(error)); });
}

/// Moves the polygons of a draft to its sets.
Result<void> settle_polygon(Draft& draft) {
    if (draft.holes && !draft.polygon) return failure(ErrorCode::Malformed, "holes needs the member polygon", "/holes");
    if (!draft.polygon && !draft.geometry) return {};
    const bool both = draft.polygon && draft.geometry;
    if (both || draft.domain)
        return failure(ErrorCode::Malformed, "at most one of polygon, geometry and domain must be given");
    auto* const plane = std::get_if<PlaneSets>(&draft.request.points);
    if (plane == nullptr)
        return failure(ErrorCode::Malformed, "points in polygons must have two coordinates",
                       draft.polygon ? "/polygon" : "/geometry");
    plane->polygon = polygons_of(std::move(draft.geometry), std::move(draft.polygon), std::move(draft.holes));
    return {};
}

Result<void> settle_points(Draft& draft, const Limits& limits) {
    if (draft.points.has_value() == draft.sets.has_value()) {
        return failure(ErrorCode::Malformed, "exactly one of points and sets must be given");
    }
    AnalyzeRequest& request = draft.request;
    request.single = draft.points.has_value();
    request.points = request.single ? *std::move(draft.points) : *std::move(draft.sets);
    const bool domain_fits = std::visit(
        [&](auto& given) {
            request.options.max_frequency = draft.max_frequency.value_or(given.kMaxFrequency);
            if (!draft.domain) return true;
            const auto* const domain = std::get_if<decltype(given.domain)>(&*draft.domain);
            if (domain != nullptr) given.domain = *domain;
            return domain != nullptr;
        },
        request.points);
    if (!domain_fits)
        return failure(ErrorCode::Malformed, "domain must have a depth if and only if points have three coordinates",
                       "/domain");
    if (auto checked = check_count(request, limits); !checked) return checked;
    if (auto settled = settle_polygon(draft); !settled) return settled;
    return std::visit([&](const auto& given) { return check_sets(request, given); }, request.points);
}

Result<std::string> write_figures(const AnalyzeRequest& request, const Analysis& analysis) {
    return write_analysis(analysis, request.spectrum);
}

Result<std::string> draw_plot(const AnalyzeRequest& request, const Analysis& analysis) {
    const double max_frequency = request.options.max_frequency;
    if (const auto* const flat = std::get_if<PlaneSets>(&request.points)) {
        if (!flat->polygon)
            return plot_spectrum(analysis, flat->sets[0], {flat->domain.width, flat->domain.height}, max_frequency);
        const Box box = bounds_of(flat->polygon->parts);
        std::vector<Point> points = flat->sets[0];
        for (Point& p : points) p = p - box.min;
        return plot_spectrum(analysis, points, {box.width(), box.height()}, max_frequency);
    }
    const auto& space = std::get<SpaceSets>(request.points);
    return plot_spectrum(analysis, space.sets[0], space.domain.sides, max_frequency);
}

Result<std::string> render_plot(const AnalyzeRequest& request, const Analysis& analysis) {
    return draw_plot(request, analysis).and_then([](const std::string& svg) {
        return render_svg(svg, kPixelsPerUnit);
    });
}

constexpr double kPlotBytes = 32 << 20;

constexpr AnalysisFormat kJsonFigures{kJson, {}, write_figures};
constexpr AnalysisFormat kPngPlot{kPng, {kPlotBytes, 0.1}, render_plot};
constexpr AnalysisFormat kSvgPlot{kSvg, {kPlotBytes, 0}, draw_plot};

constexpr const AnalysisFormat* kFormats[] = {&kJsonFigures, &kPngPlot, &kSvgPlot};

}  // namespace

std::span<const AnalysisFormat* const> analyze_formats() {
    return kFormats;
}

std::vector<std::string_view> analyze_options() {
    return names_of<Draft>(kRules);
}

Result<AnalyzeRequest> parse_analyze(std::string_view body, std::string_view accept, const Limits& limits) {
    Draft draft;
    if (auto read = read_body<Draft>(kRules, body, limits, draft); !read) return tl::unexpected(read.error());
    ErrorList errors;
    errors.add(settle_points(draft, limits));
    errors.add(settle_format(accept, analyze_formats(), draft.request.format));
    if (auto settled = errors.result(); !settled) return tl::unexpected(settled.error());
    return std::move(draft.request);
}

Result<Answer> run_analyze(const AnalyzeRequest& request, const Control& control, Timings& timings) {
    Stopwatch watch;
    const auto analysis =
        std::visit([&](const auto& given) { return analyse_sets(request, given, control.stop); }, request.points);
    timings.optimise = watch.lap();
    if (!analysis) return tl::unexpected(analysis.error());
    auto body = request.format->write(request, *analysis);
    timings.encode = watch.lap();
    if (!body) return tl::unexpected(body.error());
    return Answer{request.format->file.content_type(), *std::move(body)};
}

Cost cost_of(const AnalyzeRequest& request) {
    const bool is_in_space = std::holds_alternative<SpaceSets>(request.points);
    const auto [sets, points] = std::visit(
        [](const auto& given) {
            const std::size_t count = given.sets.empty() ? 0 : given.sets.front().size();
            return std::pair(static_cast<double>(given.sets.size()), static_cast<double>(count));
        },
        request.points);
    const auto* const plane = std::get_if<PlaneSets>(&request.points);
    const bool in_polygons = plane != nullptr && plane->polygon;
    // Frequencies are those of the bounding box; overlaps may halve the area.
    const double share = in_polygons ? share_of_box(plane->polygon->parts) / 2 : 1;
    const double waves = points * elementary::pow(request.options.max_frequency, is_in_space ? 3 : 2) / share;
    // Number of the cells of the grid, and of the parts in which the frequencies are computed.
    const double cells = waves * (is_in_space ? 64 : 16), parts = std::max(2.3 * cells / kMaxCells, 1.0);
    const bool in_parts = cells > kMaxCells;
    const double bytes = in_parts ? 600e6 + waves * (is_in_space ? 75 : 40) : waves * (is_in_space ? 1250 : 360);
    const double time = is_in_space ? waves * 1.6 + points * parts * 2.4 : waves * (in_parts ? 0.7 : 0.4);
    const Estimate transforms{bytes, time * sets * kMicrosecond};
    const Estimate others{points * sets * (is_in_space ? 96 : 64), points * sets * kMicrosecond};
    const Estimate taper = in_polygons ? Estimate{100e6, 0.7} : Estimate{};
    return total_cost(transforms + taper + others + request.format->cost);
}

std::size_t size_of(const AnalyzeRequest& request) {
    const bool is_in_space = std::holds_alternative<SpaceSets>(request.points);
    return count_points(request) * (is_in_space ? sizeof(Point3) : sizeof(Point));
}

}  // namespace ccdt::api
