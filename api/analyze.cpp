#include "api/analyze.h"

#include <array>
#include <optional>
#include <utility>

#include "api/input/negotiation.h"
#include "api/input/polygon_reader.h"
#include "api/json/json_writer.h"
#include "api/output/formats.h"
#include "api/output/spectrum_plot.h"
#include "api/output/svg_renderer.h"
#include "api/stopwatch.h"

namespace ccdt::api {
namespace {

using Set = std::vector<Point>;

constexpr Interval kFrequencies = {.min = 1, .max = 16};
constexpr double kPixelsPerUnit = 2;  // of a plot

/// In the order of AnalyzeFormat, which is the server's preference.
constexpr std::array<Format, 3> kFormats = {kJson, kPng, kSvg};

/// A request on its way: what is given is known, whether it fits together is not.
struct Draft {
    AnalyzeRequest request;
    std::optional<Set> points;
    std::optional<std::vector<Set>> sets;
    std::optional<std::size_t> format;  ///< index into kFormats
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
    {"format", [](const Input& i, const Limits&, Draft& d) { return assign(d.format, read_format(i, kFormats)); }},
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

/// The JSON Pointer, in the request, to what analyse() calls `field`.
std::string locate(const AnalyzeRequest& request, std::string_view field) {
    if (!field.empty() && field.front() != '/') return '/' + std::string(field);
    if (!request.single) return "/sets" + std::string(field);
    const auto point = field.find('/', 1);
    return "/points" + std::string(point == std::string_view::npos ? "" : field.substr(point));
}

Result<std::string> encode(const AnalyzeRequest& request, const Analysis& analysis, const Domain& domain) {
    if (request.format == AnalyzeFormat::Json) return write_analysis(analysis, request.spectrum);
    auto svg = plot_spectrum(analysis, request.sets[0], domain, request.options.max_frequency);
    if (!svg || request.format == AnalyzeFormat::Svg) return svg;
    return render_svg(*svg, kPixelsPerUnit);
}

}  // namespace

Result<AnalyzeRequest> parse_analyze(std::string_view body, std::string_view accept, const Limits& limits) {
    Draft draft;
    if (auto read = read_body<Draft>(kRules, body, limits, draft); !read) return tl::unexpected(read.error());
    if (auto settled = settle_points(draft, limits); !settled) return tl::unexpected(settled.error());
    if (!draft.format) {
        if (auto chosen = assign(draft.format, negotiate(accept, kFormats)); !chosen) {
            return tl::unexpected(chosen.error());
        }
    }
    draft.request.format = static_cast<AnalyzeFormat>(*draft.format);
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
            analysis.error().field = locate(request, analysis.error().field);
        return tl::unexpected(analysis.error());
    }
    auto body = encode(request, *analysis, *domain);
    timings.encode = watch.lap();
    if (!body) return tl::unexpected(body.error());
    return Answer{kFormats[static_cast<std::size_t>(request.format)].content_type(), *std::move(body)};
}

}  // namespace ccdt::api
