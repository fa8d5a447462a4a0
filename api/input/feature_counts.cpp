// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/feature_counts.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <string_view>
#include <utility>

#include "api/text/numbers.h"
#include "api/text/text.h"
#include "core/geometry/apportion.h"
#include "core/halftone/inks/overprint.h"

namespace ccdt::api {
namespace {

constexpr std::array<OptionRule<Counting>, 2> kRules = {{
    {"/sites/property", [](const Input& i, const Limits&, Counting& c) { return assign(c.property, read_text(i)); }},
    {"/sites/per", [](const Input& i, const Limits&, Counting& c) { return assign(c.per, read_per(i)); }},
}};

/// Reads a count, which may be given as a string. Returns none if it is not a finite number of at least 0.
std::optional<double> number_of(JsonValue value) {
    const auto number = value.is_string()   ? parse_number<double>(trim(value.text()), std::chars_format::general)
                        : value.is_number() ? std::optional(value.number())
                                            : std::nullopt;
    return number && *number >= 0 && std::isfinite(*number) ? number : std::nullopt;
}

/// Reads the counts of one class.
Result<std::vector<double>> read_values(const FeatureSource& features, const std::string& property,
                                        FeatureCounts::Missing& missing) {
    std::vector<double> values;
    for (const JsonValue feature : features.features) {
        const std::string own = features.pointer_to(values.size());
        const auto pointer = [&] { return pointer_below(pointer_below(own, "properties"), property); };
        const auto properties = properties_of(feature, own);
        if (!properties) return tl::unexpected(properties.error());
        const auto value = *properties ? (*properties)->find(property) : std::nullopt;
        if (!value || value->is_null()) {
            if (missing.features++ == 0) missing.first = pointer();
            values.push_back(0);
            continue;
        }
        const auto number = number_of(*value);
        if (!number) {
            return failure(ErrorCode::Malformed, pointer() + " must be a number of at least 0", pointer());
        }
        values.push_back(*number);
    }
    return values;
}

/// Rounds quotas.
/// @param quotas  [classes][features]
/// @returns       [features][classes], one feature after the other
std::vector<std::size_t> rounded(std::span<const std::optional<Point3>> places,
                                 std::span<const std::vector<double>> quotas) {
    std::vector<std::size_t> counts(places.size() * quotas.size());
    std::vector<std::size_t> placed;
    std::vector<Point3> positions;
    std::vector<std::vector<double>> own(quotas.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        for (std::size_t number = 0; number < quotas.size(); ++number) {
            const double quota = quotas[number][i];
            if (places[i])
                own[number].push_back(quota);
            else
                counts[i * quotas.size() + number] = static_cast<std::size_t>(std::round(quota));
        }
        if (!places[i]) continue;
        placed.push_back(i);
        positions.push_back(*places[i]);
    }
    const auto whole = apportion(positions, own);
    for (std::size_t number = 0; number < quotas.size(); ++number) {
        for (std::size_t i = 0; i < placed.size(); ++i) counts[placed[i] * quotas.size() + number] = whole[number][i];
    }
    return counts;
}

Result<void> check_total(double total, const Limits& limits, const std::string& sites) {
    if (total <= static_cast<double>(limits.max_sites)) return {};
    std::string number;
    append_rounded(number, std::min(total, 1e18), 0);
    return failure(ErrorCode::LimitExceeded,
                   "the features have " + number + " points; this server's limit (max-sites) is " +
                       std::to_string(limits.max_sites) + ": choose a larger value of per",
                   sites);
}

}  // namespace

bool is_counted(const Input& input) {
    const auto* text = std::get_if<std::string_view>(&input.value);
    if (text != nullptr) return !text->empty() && !parse_number<double>(*text, std::chars_format::general);
    const auto value = std::get<JsonValue>(input.value);
    return value.is_string() || value.is_object();
}

Result<void> read_counted(const Input& input, Counting& counting) {
    const auto* json = std::get_if<JsonValue>(&input.value);
    if (json == nullptr || !json->is_object()) return assign(counting.property, read_text(input));
    Counting own;
    if (auto read = read_members<Counting>(kRules, *json, input.field, {}, own); !read) return read;
    if (own.per && counting.per)
        return malformed(input, "has the member per, which the request has, too: give only one of them");
    if (!own.is_requested())
        return malformed(input, "must have the member property, or per together with the option classes");
    counting.property = std::move(own.property);
    if (own.per) counting.per = own.per;
    return {};
}

Result<double> read_per(const Input& input) {
    return read_number(input, kPositive);
}

Result<std::vector<std::string>> read_classes(const Input& input) {
    return read_names(input, kMaxInks, "class");
}

std::size_t FeatureCounts::points_of(std::size_t feature) const {
    std::size_t sum = 0;
    for (std::size_t number = 0; number < classes.size(); ++number) sum += count(feature, number);
    return sum;
}

std::size_t FeatureCounts::total() const {
    return std::accumulate(counts.begin(), counts.end(), std::size_t{0});
}

Result<FeatureCounts> count_features(const FeatureSource& features, std::span<const std::optional<Point3>> places,
                                     const Counting& counting, const Limits& limits, const std::string& sites) {
    FeatureCounts result;
    result.per = counting.per.value_or(1);
    result.are_named = !counting.classes.empty();
    result.classes = result.are_named ? counting.classes : std::vector<std::string>{*counting.property};
    std::vector<std::vector<double>> quotas;
    double total = 0;
    for (const std::string& property : result.classes) {
        auto values = read_values(features, property, result.missing.emplace_back());
        if (!values) return tl::unexpected(values.error());
        for (double& value : *values) total += value /= result.per;
        if (auto checked = check_total(total, limits, sites); !checked) return tl::unexpected(checked.error());
        quotas.push_back(*std::move(values));
    }
    result.counts = rounded(places, quotas);
    if (result.total() == 0) {
        const std::string divided = counting.per ? ", divided by per," : "";
        return failure(ErrorCode::Unusable,
                       "the features have no points: their counts, added up" + divided + " round to 0", sites);
    }
    return check_total(static_cast<double>(result.total()), limits, sites).map([&] { return std::move(result); });
}

}  // namespace ccdt::api
