// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/analyze/analyze.h"

#include <array>
#include <optional>
#include <utility>

#include "api/input/negotiation.h"
#include "api/input/polygon_reader.h"
#include "api/output/json_writer.h"
#include "api/output/spectrum_plot.h"
#include "api/output/stage_costs.h"
#include "api/output/svg_renderer.h"
#include "api/run/stopwatch.h"

namespace ccdt::api {
namespace {

using Set = std::vector<Point>;

constexpr Interval kFrequencies = {.min = 1, .max = 16};
constexpr double kPixelsPerUnit = 2;  // resolution of a plot as PNG, pixels per user unit

/// A request that is being parsed. Its options have been read, but their combination has not been checked yet.
struct Draft {
    AnalyzeRequest request;
    std::optional<Set> points;
    std::optional<std::vector<Set>> sets;
};

Result<std::vector<Set>> read_sets(const Input& input) {
    const auto list = std::get<JsonValue>(input.value);
    if (!list.is_array()) return malformed(input, "must be a list of sets of points");
    std::vector<Set> sets;
    for (const JsonValue element : list) {
        const std::string pointer = pointer_below(input.field, sets.size());
        auto set = read_ring({pointer, pointer, element});
        if (!set) return tl::unexpected(set.error());
        sets.push_back(*std::move(set));
    }
    return sets;
}

constexpr std::array<OptionRule<Draft>, 6> kRules = {{
    {"points", [](const Input& i, const Limits&, Draft& d) { return assign(d.points, read_ring(i)); }},
    {"sets", [](const Input& i, const Limits&, Draft& d) { return assign(d.sets, read_sets(i)); }},
    {"domain", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.domain, read_rectangle(i)); }},
    {"spectrum", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.spectrum, read_boolean(i)); }},
    {"max_frequency", [](const Input& i, const Limits&,
                         Draft& d) { return assign(d.request.options.max_frequency, read_number(i, kFrequencies)); }},
    {"format", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.request.format, read_format(i, analyze_formats())); }},
}};

Result<void> check_count(const AnalyzeRequest& request, const Limits& limits) {
    std::size_t points = 0;
    for (const Set& set : request.sets) points += set.size();
    if (points <= limits.max_sites) return {};
    return failure(ErrorCode::LimitExceeded,
                   "there are " + std::to_string(points) + " points; this server's limit (max-sites) is " +
                       std::to_string(limits.max_sites),
                   request.single ? "/points" : "/sets");
}

Result<void> settle_points(Draft& draft, const Limits& limits) {
    if (draft.points.has_value() == draft.sets.has_value()) {
        return failure(ErrorCode::Malformed, "exactly one of points and sets must be given");
    }
    AnalyzeRequest& request = draft.request;
    request.single = draft.points.has_value();
    if (request.single) {
        request.sets.push_back(*std::move(draft.points));
    } else {
        request.sets = *std::move(draft.sets);
    }
    return check_count(request, limits);
}

/// Converts the field of an error of analyse() to a JSON Pointer in the request.
std::string pointer_to(const AnalyzeRequest& request, std::string_view field) {
    if (!field.empty() && field.front() != '/') return pointer_below("", field);
    if (!request.single) return "/sets" + std::string(field);
    const auto point = field.find('/', 1);
    return "/points" + std::string(point == std::string_view::npos ? "" : field.substr(point));
}

Result<std::string> write_figures(const AnalyzeRequest& request, const Analysis& analysis, const Domain&) {
    return write_analysis(analysis, request.spectrum);
}

Result<std::string> draw_plot(const AnalyzeRequest& request, const Analysis& analysis, const Domain& domain) {
    return plot_spectrum(analysis, request.sets[0], domain, request.options.max_frequency);
}

Result<std::string> render_plot(const AnalyzeRequest& request, const Analysis& analysis, const Domain& domain) {
    return draw_plot(request, analysis, domain).and_then([](const std::string& svg) {
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
    const auto domain = make_domain(request.domain);
    if (!domain) return tl::unexpected(domain.error());
    auto analysis = analyse(request.sets, *domain, request.options, control.stop);
    timings.optimise = watch.lap();
    if (!analysis) {
        if (analysis.error().code != ErrorCode::Stopped)
            analysis.error().field = pointer_to(request, analysis.error().field);
        return tl::unexpected(analysis.error());
    }
    auto body = request.format->write(request, *analysis, *domain);
    timings.encode = watch.lap();
    if (!body) return tl::unexpected(body.error());
    return Answer{request.format->file.content_type(), *std::move(body)};
}

Cost cost_of(const AnalyzeRequest& request) {
    const auto sets = static_cast<double>(request.sets.size());
    const double points = request.sets.empty() ? 0 : static_cast<double>(request.sets.front().size());
    const double cells = points * request.options.max_frequency * request.options.max_frequency;
    const bool in_parts = cells * 16 > static_cast<double>(kMaxCells);
    constexpr double kParts = 600e6, kSpectrum = 40;
    const Estimate transforms{in_parts ? kParts + cells * kSpectrum : cells * 360,
                              cells * sets * (in_parts ? 0.7 : 0.4) * kMicrosecond};
    const Estimate others{points * sets * 64, points * sets * kMicrosecond};
    return total_cost(transforms + others + request.format->cost);
}

std::size_t size_of(const AnalyzeRequest& request) {
    std::size_t points = 0;
    for (const auto& set : request.sets) points += set.size();
    return points * sizeof(Point);
}

}  // namespace ccdt::api
