// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/choice/choice_parser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "api/input/degrees.h"
#include "api/input/negotiation.h"
#include "api/input/option_reader.h"
#include "api/input/point_reader.h"
#include "api/input/run_options.h"
#include "api/sample/choice/choice_formats.h"
#include "core/geometry/point.h"

namespace ccdt::api {
namespace {

/// A request that is being parsed. Its options have been read, but their combination has not been checked yet.
struct Draft {
    ChoiceRequest request;
    bool is_in_space = false;
    std::optional<bool> is_on_globe;
    std::optional<choice::Extent> domain;
    std::optional<std::uint64_t> sites;
    std::vector<std::pair<std::string, std::uint64_t>> counts;  ///< by class
    Labels classes;
    std::vector<std::uint64_t> keep;
    Options run;
    std::optional<Input> format;

    // Of a file:
    std::array<std::string, 3> axes;
    std::string density, priority, kept, label;  ///< names of columns; empty: none
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

/// Reads the number of sites, or that of each class.
Result<void> read_counts(const Input& input, Draft& draft) {
    const auto* const text = std::get_if<std::string_view>(&input.value);
    if (text != nullptr && text->starts_with('{')) {
        return parse_json(input).and_then([&](const JsonDocument& document) {
            return read_counts({input.name, input.field, document.root()}, draft).map_error([&](Error error) {
                error.field = input.field;
                return error;
            });
        });
    }
    const auto* const value = std::get_if<JsonValue>(&input.value);
    if (value == nullptr || !value->is_object()) return assign(draft.sites, read_integer(input, 0, kMaxInteger));
    std::uint64_t sum = 0;
    for (const auto& [name, count] : value->members()) {
        const std::string field = pointer_below(input.field, name);
        const auto read = read_integer({field, field, count}, 0, std::numeric_limits<std::uint32_t>::max());
        if (!read) return tl::unexpected(read.error());
        draft.counts.emplace_back(name, *read);
        sum += *read;
    }
    draft.sites = sum;
    return {};
}

/// Reads the class of each candidate.
Result<void> read_classes(const Input& input, Draft& draft) {
    const auto list = std::get<JsonValue>(input.value);
    if (!list.is_array()) return malformed(input, "must be a list of texts or numbers");
    for (const JsonValue value : list) {
        if (value.is_array() || value.is_object())
            return malformed({pointer_below(input.field, draft.classes.number.size()),
                              pointer_below(input.field, draft.classes.number.size()), value},
                             "must be a text or a number");
        draft.classes.add(label_of(value));
    }
    return {};
}

Result<void> read_column(const Input& input, std::string& column) {
    if (auto read = assign(column, read_text(input)); !read) return read;
    return column.empty() ? malformed(input, "must be the name of a column") : Result<void>();
}

constexpr Interval kAny = {.min = -1.7976931348623157e308, .max = 1.7976931348623157e308};
constexpr Interval kNotNegative = {.min = 0, .max = 1.7976931348623157e308};
constexpr Choice<bool> kCoordinates[] = {{"plane", false}, {"lonlat", true}};
constexpr Choice<bool> kOrders[] = {{"none", false}, {"progressive", true}};
constexpr Choice<choice::Extent> kDomains[] = {{"surface", choice::Extent::Surface}, {"solid", choice::Extent::Solid}};
constexpr std::array<std::string_view, 1> kBody{"body"};

constexpr std::array<OptionRule<Draft>, 8> kRules = {{
    {"sites", [](const Input& i, const Limits&, Draft& d) { return read_counts(i, d); }},
    {"spacing",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.spacing, read_number(i, kPositive)); }},
    {"coordinates",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.is_on_globe, read_choice<bool>(i, kCoordinates)); }},
    {"domain", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.domain, read_choice<choice::Extent>(i, kDomains)); }},
    {"order", [](const Input& i, const Limits&,
                 Draft& d) { return assign(d.request.is_progressive, read_choice<bool>(i, kOrders)); }},
    {"seed", [](const Input& i, const Limits&, Draft& d) { return read_seed(i, d.run); }},
    {"on_deadline",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.on_deadline, read_on_deadline(i)); }},
    {"format", [](const Input& i, const Limits&, Draft& d) -> Result<void> { return d.format = i, Result<void>(); }},
}};

/// Members of JSON.
constexpr std::array<OptionRule<Draft>, 5> kMemberRules = {{
    {"candidates", [](const Input& i, const Limits& l, Draft& d) { return read_candidates(i, l, d); }},
    {"classes", [](const Input& i, const Limits&, Draft& d) { return read_classes(i, d); }},
    {"density",
     [](const Input& i, const Limits& l, Draft& d) {
         if (std::get<JsonValue>(i.value).is_object()) return assign(d.request.density_map, read_density(i, l));
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
}};
constexpr auto kJsonRules = joined(kRules, kMemberRules);

/// Options beside a file.
constexpr std::array<OptionRule<Draft>, 8> kColumnRules = {{
    {"candidates", [](const Input& i, const Limits&, Draft&) { return read_word(i, kBody).map([](std::size_t) {}); }},
    {"x", [](const Input& i, const Limits&, Draft& d) { return read_column(i, d.axes[0]); }},
    {"y", [](const Input& i, const Limits&, Draft& d) { return read_column(i, d.axes[1]); }},
    {"z", [](const Input& i, const Limits&, Draft& d) { return read_column(i, d.axes[2]); }},
    {"density", [](const Input& i, const Limits&, Draft& d) { return read_column(i, d.density); }},
    {"priority", [](const Input& i, const Limits&, Draft& d) { return read_column(i, d.priority); }},
    {"keep", [](const Input& i, const Limits&, Draft& d) { return read_column(i, d.kept); }},
    {"classes", [](const Input& i, const Limits&, Draft& d) { return read_column(i, d.label); }},
}};
constexpr auto kFileRules = joined(kRules, kColumnRules);

Result<void> check_length(const ChoiceRequest& request, const std::vector<double>& list, std::string_view name) {
    if (list.empty() || list.size() == request.candidates.size()) return {};
    return failure(ErrorCode::Malformed,
                   std::string(name) + " has " + std::to_string(list.size()) + " numbers, but there are " +
                       std::to_string(request.candidates.size()) + " candidates",
                   pointer_below("", name));
}

/// @param field  Error::field of an option
Result<void> settle_sites(Draft& draft, std::string_view sites, std::string_view spacing) {
    const std::string field(sites);
    const std::size_t candidates = draft.request.candidates.size();
    if (draft.request.spacing) {
        if (draft.sites)
            return failure(ErrorCode::Malformed, "spacing determines the number of sites, so both cannot be given",
                           std::string(spacing));
        const bool has_density = !draft.request.density.empty() || draft.request.density_map.index() > 0;
        if (!draft.classes.number.empty() || has_density)
            return failure(ErrorCode::Malformed, "spacing cannot be combined with classes or a density",
                           std::string(spacing));
        return {};
    }
    if (!draft.sites) return failure(ErrorCode::Malformed, "sites is missing", field);
    if (*draft.sites > candidates)
        return failure(ErrorCode::Unusable,
                       "sites is " + std::to_string(*draft.sites) + ", but there are only " +
                           std::to_string(candidates) + " candidates",
                       field);
    draft.request.sites = *draft.sites;
    return {};
}

/// @param sites    Error::field of the option `sites`
/// @param classes  that of the option `classes`
Result<void> settle_classes(Draft& draft, std::string_view sites, std::string_view classes) {
    constexpr std::size_t kMaxClasses = 1'000;
    const Labels& labels = draft.classes;
    if (draft.counts.empty() && labels.number.empty()) return {};
    if (labels.number.empty())
        return failure(ErrorCode::Malformed, "sites for each class need classes", std::string(sites));
    if (labels.number.size() != draft.request.candidates.size())
        return failure(ErrorCode::Malformed,
                       "classes has " + std::to_string(labels.number.size()) + " members, but there are " +
                           std::to_string(draft.request.candidates.size()) + " candidates",
                       std::string(classes));
    if (labels.names.size() > kMaxClasses)
        return failure(ErrorCode::LimitExceeded,
                       "there are " + std::to_string(labels.names.size()) + " classes, more than the limit, " +
                           std::to_string(kMaxClasses),
                       std::string(classes));
    draft.request.classes = labels.number;
    if (draft.counts.empty()) return {};
    draft.request.counts.assign(labels.names.size(), 0);
    for (const auto& [name, count] : draft.counts) {
        const auto found = std::ranges::find(labels.names, name);
        if (found == labels.names.end())
            return failure(ErrorCode::Malformed,
                           "there is no class '" + excerpt(name) + "'; the classes are " + join_names(labels.names),
                           std::string(sites));
        const auto number = static_cast<std::size_t>(found - labels.names.begin());
        const auto members = static_cast<std::size_t>(std::ranges::count(labels.number, number));
        if (count > members)
            return failure(ErrorCode::Unusable,
                           "sites is " + std::to_string(count) + " for the class '" + excerpt(name) +
                               "', which has only " + std::to_string(members) + " candidates",
                           std::string(sites));
        draft.request.counts[number] = count;
    }
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

/// @param field     Error::field of an option
/// @param place_of  place of a candidate for messages, or its JSON Pointer
Result<void> settle_space(Draft& draft, const std::function<std::string(std::string_view)>& field,
                          const std::function<std::string(std::size_t)>& place_of) {
    ChoiceRequest& request = draft.request;
    request.is_on_globe = draft.is_on_globe.value_or(false);
    if (draft.domain && !draft.is_in_space)
        return failure(ErrorCode::Malformed, "domain needs candidates with three coordinates", field("domain"));
    if (request.is_on_globe && draft.is_in_space)
        return failure(ErrorCode::Malformed, "coordinates=lonlat needs candidates with two coordinates",
                       field("coordinates"));
    if (draft.is_in_space && request.density_map.index() > 0)
        return failure(ErrorCode::Malformed, "density must be a list for candidates with three coordinates",
                       field("density"));
    if (draft.is_in_space) request.extent = draft.domain.value_or(choice::Extent::Surface);
    if (!request.is_on_globe) return {};
    request.extent = choice::Extent::Surface;
    for (std::size_t i = 0; i < request.candidates.size(); ++i) {
        const Point3 p = request.candidates[i];
        if (std::abs(p.x) > 540 || std::abs(p.y) > 90) {
            const std::string place = place_of(i);
            return failure(ErrorCode::Malformed,
                           place + " is not a longitude from -540 to 540 and a latitude from -90 to 90",
                           place.starts_with('/') ? place : field("coordinates"));
        }
    }
    return {};
}

Result<void> settle_format(Draft& draft, std::string_view accept, std::optional<PointFileKind> kind) {
    const auto offered = choice_formats(kind);
    if (!draft.format) return api::settle_format(accept, offered, draft.request.format);
    return assign(draft.request.format, read_format(*draft.format, offered));
}

/// Copies a column of a file that an option names.
/// @param check  whether a number is allowed
template <class Number, class Check>
Result<void> take_column(const PointTable& table, std::string_view file, std::size_t& next, std::string_view option,
                         std::string_view column, std::string_view allowed, std::vector<Number>& target,
                         Check&& check) {
    if (column.empty()) return {};
    const std::vector<double>& values = table.columns[next++];
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!check(values[i]))
            return failure(ErrorCode::Malformed,
                           table.place_of(i, file) + ": " + excerpt(column) + " must be " + std::string(allowed),
                           std::string(option));
        target.push_back(static_cast<Number>(std::isnan(values[i]) ? 0 : values[i]));
    }
    return {};
}

Result<void> take_columns(Draft& draft, const PointTable& table, std::string_view file) {
    std::size_t next = 0;
    ErrorList errors;
    const auto is_density = [](double value) { return value >= 0 && std::isfinite(value); };
    const auto is_priority = [](double value) { return std::isfinite(value); };
    const auto is_flag = [](double value) { return std::isnan(value) || value == 0 || value == 1; };
    errors.add(take_column(table, file, next, "density", draft.density, "a number of at least 0", draft.request.density,
                           is_density));
    errors.add(
        take_column(table, file, next, "priority", draft.priority, "a number", draft.request.priority, is_priority));
    errors.add(
        take_column(table, file, next, "keep", draft.kept, "empty, 0, 1, true or false", draft.request.kept, is_flag));
    return errors.result();
}

/// Reads the points and columns of a file.
Result<void> read_file(std::string_view file, const Limits& limits, Draft& draft) {
    PointColumns columns{.axes = draft.axes, .names = {}, .label = draft.label, .by_record = true};
    for (const std::string* name : {&draft.density, &draft.priority, &draft.kept}) {
        if (!name->empty()) columns.names.push_back(*name);
    }
    auto table = read_point_table(file, columns, limits);
    if (!table) {
        // The option that names the column.
        const std::pair<std::string_view, const std::string&> options[] = {
            {"x", draft.axes[0]},         {"y", draft.axes[1]}, {"z", draft.axes[2]},    {"density", draft.density},
            {"priority", draft.priority}, {"keep", draft.kept}, {"classes", draft.label}};
        for (const auto& [option, column] : options) {
            if (column.empty() || column != table.error().field) continue;
            table.error().field = option;
            break;
        }
        return tl::unexpected(table.error());
    }
    if (auto taken = take_columns(draft, *table, file); !taken) return taken;
    ChoiceRequest& request = draft.request;
    request.candidates = std::exchange(table->positions, {});
    table->columns.clear();
    draft.classes = std::exchange(table->labels, {});
    draft.is_in_space = table->dimensions == 3;
    if (!draft.is_on_globe && table->is_lonlat) draft.is_on_globe = true;
    if (table->left_out > 0)
        request.warnings.push_back(
            {"", "records without coordinates are left out: " + std::to_string(table->left_out)});
    request.table = *std::move(table);
    return {};
}

void warn_of_degrees(ChoiceRequest& request) {
    const PointFileKind kind = request.table.kind;
    const bool may_be =
        kind == PointFileKind::GeoJson || kind == PointFileKind::JsonLines || kind == PointFileKind::JsonSequence;
    if (!may_be || request.is_on_globe || request.candidates.empty()) return;
    const Point3 first = request.candidates.front();
    Box box{{first.x, first.y}, {first.x, first.y}};
    for (const Point3 p : request.candidates) box.include({p.x, p.y});
    if (auto warning = warning_of_degrees(box)) request.warnings.push_back({"coordinates", *std::move(warning)});
}

}  // namespace

std::vector<std::string_view> choice_options() {
    return names_of<Draft>(kFileRules);
}

bool asks_for_choice(JsonValue root) {
    return root.is_object() && root.find("candidates") && !root.find("type");  // a map has a type
}

bool asks_for_choice(const std::vector<TextOption>& options) {
    return std::ranges::find(options, "candidates", &TextOption::name) != options.end();
}

Result<ChoiceRequest> parse_choice(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                   const Limits& limits) {
    if (!options.empty())
        return failure(ErrorCode::Malformed, "options must be members of the JSON body", excerpt(options.front().name));
    Draft draft;
    if (auto read = read_members<Draft>(kJsonRules, root, "", limits, draft); !read)
        return tl::unexpected(read.error());
    ErrorList errors;
    errors.add(settle_sites(draft, "/sites", "/spacing"));
    errors.add(settle_classes(draft, "/sites", "/classes"));
    errors.add(check_length(draft.request, draft.request.density, "density"));
    errors.add(check_length(draft.request, draft.request.priority, "priority"));
    errors.add(settle_kept(draft));
    errors.add(settle_space(
        draft, [](std::string_view option) { return pointer_below("", option); },
        [](std::size_t i) { return pointer_below("/candidates", i); }));
    errors.add(settle_format(draft, accept, std::nullopt));
    if (auto settled = errors.result(); !settled) return tl::unexpected(settled.error());
    draft.request.seed = draft.run.seed;
    return std::move(draft.request);
}

Result<ChoiceRequest> parse_choice(std::string_view file, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits) {
    Draft draft;
    if (auto read = read_options<Draft>(kFileRules, inputs_of(options), limits, draft); !read)
        return tl::unexpected(read.error());
    if (auto read = read_file(file, limits, draft); !read) return tl::unexpected(read.error());
    ChoiceRequest& request = draft.request;
    ErrorList errors;
    errors.add(settle_sites(draft, "sites", "spacing"));
    errors.add(settle_classes(draft, "sites", "classes"));
    errors.add(settle_space(
        draft, [](std::string_view option) { return std::string(option); },
        [&](std::size_t i) { return request.table.place_of(i, file); }));
    errors.add(settle_format(draft, accept, request.table.kind));
    if (auto settled = errors.result(); !settled) return tl::unexpected(settled.error());
    request.seed = draft.run.seed;
    request.is_file = true;
    warn_of_degrees(request);
    if (request.format->has_records)
        request.file = file;
    else
        request.table.records.clear();
    return std::move(request);
}

}  // namespace ccdt::api
