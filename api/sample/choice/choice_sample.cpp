// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/choice/choice_sample.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "api/input/negotiation.h"
#include "api/input/option_reader.h"
#include "api/input/point_reader.h"
#include "api/input/run_options.h"
#include "api/output/npy_header.h"
#include "api/output/stage_costs.h"
#include "api/run/stopwatch.h"
#include "api/text/numbers.h"
#include "core/ccdt/globe/chart.h"

namespace ccdt::api {
namespace {

/// A request that is being parsed. Its options have been read, but their combination has not been checked yet.
struct Draft {
    ChoiceRequest request;
    bool is_in_space = false;
    std::optional<choice::Extent> domain;
    std::optional<std::uint64_t> sites;
    std::vector<std::uint64_t> keep;
    Options run;
};

Result<void> read_candidates(const Input& input, const Limits& limits, Draft& draft) {
    const auto value = std::get<JsonValue>(input.value);
    const bool is_list = value.is_array() && value.size() > 0 && (*value.begin()).is_array();
    draft.is_in_space = is_list && (*value.begin()).size() == 3;
    if (draft.is_in_space) return assign(draft.request.candidates, read_points3(input, limits));
    const auto points = read_points(input, limits);
    if (!points) return tl::unexpected(points.error());
    for (const Point p : *points) draft.request.candidates.push_back({p.x, p.y, 0});
    return {};
}

/// Reads a list of numbers, with a function that reads one of them.
template <class Number, class Read>
Result<void> read_numbers(const Input& input, std::vector<Number>& numbers, Read&& read) {
    const auto list = std::get<JsonValue>(input.value);
    if (!list.is_array()) return malformed(input, "must be a list of numbers");
    for (const JsonValue value : list) {
        const std::string field = pointer_below(input.field, numbers.size());
        const auto number = read(Input{field, field, value});
        if (!number) return tl::unexpected(number.error());
        numbers.push_back(*number);
    }
    return {};
}

constexpr Interval kAny = {.min = -1.7976931348623157e308, .max = 1.7976931348623157e308};
constexpr Interval kNotNegative = {.min = 0, .max = 1.7976931348623157e308};
constexpr Choice<bool> kCoordinates[] = {{"plane", false}, {"lonlat", true}};
constexpr Choice<choice::Extent> kDomains[] = {{"surface", choice::Extent::Surface}, {"solid", choice::Extent::Solid}};

constexpr std::array<OptionRule<Draft>, 10> kRules = {{
    {"candidates", [](const Input& i, const Limits& l, Draft& d) { return read_candidates(i, l, d); }},
    {"sites", [](const Input& i, const Limits&, Draft& d) { return assign(d.sites, read_integer(i, 0, kMaxInteger)); }},
    {"density",
     [](const Input& i, const Limits&, Draft& d) {
         return read_numbers(i, d.request.density, [](const Input& each) { return read_number(each, kNotNegative); });
     }},
    {"priority",
     [](const Input& i, const Limits&, Draft& d) {
         return read_numbers(i, d.request.priority, [](const Input& each) { return read_number(each, kAny); });
     }},
    {"keep",
     [](const Input& i, const Limits&, Draft& d) {
         return read_numbers(i, d.keep, [](const Input& each) { return read_integer(each, 0, kMaxInteger); });
     }},
    {"coordinates", [](const Input& i, const Limits&,
                       Draft& d) { return assign(d.request.is_on_globe, read_choice<bool>(i, kCoordinates)); }},
    {"domain", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.domain, read_choice<choice::Extent>(i, kDomains)); }},
    {"seed", [](const Input& i, const Limits&, Draft& d) { return read_seed(i, d.run); }},
    {"on_deadline",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.on_deadline, read_on_deadline(i)); }},
    {"format", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.request.format, read_format(i, choice_formats())); }},
}};

Result<void> check_length(const ChoiceRequest& request, const std::vector<double>& list, std::string_view name) {
    if (list.empty() || list.size() == request.candidates.size()) return {};
    return failure(ErrorCode::Malformed,
                   std::string(name) + " has " + std::to_string(list.size()) + " numbers, but there are " +
                       std::to_string(request.candidates.size()) + " candidates",
                   pointer_below("", name));
}

Result<void> settle_sites(Draft& draft) {
    const std::size_t candidates = draft.request.candidates.size();
    if (!draft.sites) return failure(ErrorCode::Malformed, "sites is missing", "/sites");
    if (*draft.sites > candidates)
        return failure(ErrorCode::Unusable,
                       "sites is " + std::to_string(*draft.sites) + ", but there are only " +
                           std::to_string(candidates) + " candidates",
                       "/sites");
    draft.request.sites = *draft.sites;
    return {};
}

Result<void> settle_kept(Draft& draft) {
    ChoiceRequest& request = draft.request;
    if (draft.keep.empty()) return {};
    request.kept.assign(request.candidates.size(), 0);
    for (std::size_t each = 0; each < draft.keep.size(); ++each) {
        if (draft.keep[each] >= request.candidates.size())
            return failure(ErrorCode::Malformed,
                           "keep has the index " + std::to_string(draft.keep[each]) + ", but there are only " +
                               std::to_string(request.candidates.size()) + " candidates",
                           pointer_below("/keep", each));
        request.kept[draft.keep[each]] = 1;
    }
    return {};
}

Result<void> settle_space(Draft& draft) {
    ChoiceRequest& request = draft.request;
    if (draft.domain && !draft.is_in_space)
        return failure(ErrorCode::Malformed, "domain needs candidates with three coordinates", "/domain");
    if (request.is_on_globe && draft.is_in_space)
        return failure(ErrorCode::Malformed, "coordinates=lonlat needs candidates with two coordinates",
                       "/coordinates");
    if (draft.is_in_space) request.extent = draft.domain.value_or(choice::Extent::Surface);
    if (!request.is_on_globe) return {};
    request.extent = choice::Extent::Surface;
    for (std::size_t i = 0; i < request.candidates.size(); ++i) {
        const Point3 p = request.candidates[i];
        if (std::abs(p.x) > 540 || std::abs(p.y) > 90)
            return failure(ErrorCode::Malformed,
                           "candidates must be longitudes from -540 to 540 and latitudes from -90 "
                           "to 90",
                           pointer_below("/candidates", i));
    }
    return {};
}

bool has_height(const ChoiceRequest& request) {
    return request.extent != choice::Extent::Plane && !request.is_on_globe;
}

void append_position(std::string& out, const ChoiceRequest& request, std::uint32_t row) {
    const Point3 p = request.candidates[row];
    append_shortest(out, p.x);
    append_shortest(out += ',', p.y);
    if (has_height(request)) append_shortest(out += ',', p.z);
}

void write_json(const ChoiceRequest& request, const ChosenCandidates& chosen, bool partial, std::string& out) {
    out += "{\"indices\":[";
    for (const std::uint32_t row : chosen.rows) out += std::to_string(row) += ',';
    if (!chosen.rows.empty()) out.pop_back();
    out += "],\"points\":[";
    for (const std::uint32_t row : chosen.rows) {
        append_position(out += '[', request, row);
        out += "],";
    }
    if (!chosen.rows.empty()) out.pop_back();
    out += "],\"sites\":" + std::to_string(chosen.rows.size()) + ",\"seed\":" + std::to_string(request.seed) +
           ",\"shortfall\":" + std::to_string(chosen.shortfall) + (partial ? ",\"partial\":true}\n" : "}\n");
}

void write_csv(const ChoiceRequest& request, const ChosenCandidates& chosen, bool /*partial*/, std::string& out) {
    out += has_height(request) ? "index,x,y,z\r\n" : "index,x,y\r\n";
    for (const std::uint32_t row : chosen.rows) {
        append_position(out += std::to_string(row) += ',', request, row);
        out += "\r\n";
    }
}

void write_npy(const ChoiceRequest& /*request*/, const ChosenCandidates& chosen, bool /*partial*/, std::string& out) {
    static_assert(std::endian::native == std::endian::little);
    out += npy_header("<u4", chosen.rows.size(), 1);
    out.append(reinterpret_cast<const char*>(chosen.rows.data()), chosen.rows.size() * sizeof(std::uint32_t));
}

constexpr ChoiceFormat kJsonChoice{kJson, 80, write_json};
constexpr ChoiceFormat kCsvChoice{kCsv, 80, write_csv};
constexpr ChoiceFormat kNpyChoice{kNpy, 4, write_npy};
constexpr const ChoiceFormat* kFormats[] = {&kJsonChoice, &kCsvChoice, &kNpyChoice};

}  // namespace

std::span<const ChoiceFormat* const> choice_formats() {
    return kFormats;
}

std::vector<std::string_view> choice_options() {
    return names_of<Draft>(kRules);
}

bool asks_for_choice(JsonValue root) {
    return root.is_object() && root.find("candidates") && !root.find("type");  // a map has a type
}

Result<ChoiceRequest> parse_choice(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                   const Limits& limits) {
    if (!options.empty())
        return failure(ErrorCode::Malformed, "options must be members of the JSON body", excerpt(options.front().name));
    Draft draft;
    if (auto read = read_members<Draft>(kRules, root, "", limits, draft); !read) return tl::unexpected(read.error());
    ErrorList errors;
    errors.add(settle_sites(draft));
    errors.add(check_length(draft.request, draft.request.density, "density"));
    errors.add(check_length(draft.request, draft.request.priority, "priority"));
    errors.add(settle_kept(draft));
    errors.add(settle_space(draft));
    errors.add(settle_format(accept, choice_formats(), draft.request.format));
    if (auto settled = errors.result(); !settled) return tl::unexpected(settled.error());
    draft.request.seed = draft.run.seed;
    return std::move(draft.request);
}

Result<Answer> run_choice(const ChoiceRequest& request, const Control& control, Timings& timings, BodySink* sink) {
    Stopwatch watch;
    std::vector<Point3> directions;
    if (request.is_on_globe) {
        for (const Point3 p : request.candidates) {
            const Direction d = direction_of({p.x, p.y});
            directions.push_back({d.x, d.y, d.z});
        }
    }
    const Candidates candidates{.positions = request.is_on_globe ? directions : request.candidates,
                                .extent = request.extent,
                                .density = request.density,
                                .priority = request.priority,
                                .kept = request.kept,
                                .torus = {}};
    timings.prepare = watch.lap();
    const auto chosen = choose_points(candidates, request.sites, request.seed, control.stop, *control.executor);
    timings.optimise = watch.lap();
    if (!chosen) return tl::unexpected(error_below(chosen.error(), ""));

    Answer answer;
    answer.partial = control.stop.stop_requested();
    if (auto whole = check_whole(answer.partial, request.on_deadline); !whole) return tl::unexpected(whole.error());
    answer.media_type = request.format->file.content_type();
    answer.sites = request.sites;
    Body body(answer, sink, stop_of_writing(control, request.on_deadline));
    request.format->write(request, *chosen, answer.partial, body.text());
    timings.encode = watch.lap();
    return body.finish(std::move(answer));
}

Cost cost_of(const ChoiceRequest& request) {
    // Measured: 1 million candidates with 100,000 sites, and 20,480 with 4,096. A site is visited 20 to 200 times.
    constexpr Estimate kCandidate{250, 2 * kMicrosecond}, kVisit{0, 1.2 * kMicrosecond};
    const auto sites = static_cast<double>(request.sites), candidates = static_cast<double>(request.candidates.size());
    const double visits = std::min(200 * sites, std::max(2e6, 20 * sites));
    return total_cost(kCandidate * candidates + kVisit * visits + Estimate{sites * request.format->bytes_per_site, 0});
}

std::size_t size_of(const ChoiceRequest& request) {
    return request.candidates.size() * sizeof(Point3) + request.kept.size() +
           (request.density.size() + request.priority.size()) * sizeof(double);
}

}  // namespace ccdt::api
