// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/feature_list.h"

#include <algorithm>
#include <array>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "api/text/similar_name.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

/// Names of the properties and columns that answers have for their own purposes.
constexpr std::array<std::string_view, 8> kOwnNames = {"x",          "y",     "rank",  "feature",
                                                       "feature_id", "class", "color", "sites"};

std::string id_of(JsonValue feature) {
    const auto id = feature.is_object() ? feature.find("id") : std::nullopt;
    std::string text;
    if (id && (id->is_string() || id->is_number())) append_json(text, *id);
    return text;
}

/// Collects the feature properties that points carry.
class Collector {
public:
    Collector(const PropertyChoice& choice, const std::string& option) : choice_(choice), option_(option) {
        for (const std::string& name : choice.names) add_name(name);
    }

    /// Adds the properties of the next feature.
    Result<void> add(JsonValue feature, const std::string& pointer) {
        const auto properties = properties_of(feature, pointer);
        if (!properties) return tl::unexpected(properties.error());
        std::vector<CarriedProperties::Value> values;
        if (*properties) {
            for (const auto& [name, value] : (*properties)->members()) {
                const auto number = number_of(name);
                if (!number) continue;
                CarriedProperties::Value carried{*number, value.is_string(), {}};
                if (carried.is_text) {
                    carried.value = value.text();
                } else {
                    append_json(carried.value, value);
                }
                values.push_back(std::move(carried));
            }
        }
        if (names_.size() > PropertyChoice::kMax)
            return failure(
                ErrorCode::LimitExceeded,
                "the features have more than " + std::to_string(PropertyChoice::kMax) +
                    " different properties, the limit for points: list the names of those that points should carry",
                option_);
        std::ranges::sort(values, {}, &CarriedProperties::Value::name);
        carried_.of_feature.push_back(std::move(values));
        return check_last(pointer);
    }

    CarriedProperties take() {
        carried_.names = names_;
        for (std::string& name : carried_.names) make_distinct(name);
        return std::move(carried_);
    }

private:
    void add_name(const std::string& name) {
        numbers_.emplace(name, static_cast<std::uint32_t>(names_.size()));
        names_.push_back(name);
    }

    /// Finds the number of a property, or adds the property if points carry all properties. Returns none otherwise.
    std::optional<std::uint32_t> number_of(std::string_view name) {
        const std::string key(name);
        if (const auto found = numbers_.find(key); found != numbers_.end()) return found->second;
        if (!choice_.all || names_.size() > PropertyChoice::kMax) return std::nullopt;
        add_name(key);
        return static_cast<std::uint32_t>(names_.size() - 1);
    }

    Result<void> check_last(const std::string& pointer) const {
        std::size_t size = 0;
        for (const auto& [name, is_text, value] : carried_.of_feature.back())
            size += names_[name].size() + value.size();
        if (size <= CarriedProperties::kMaxOfFeature) return {};
        const std::string own = pointer_below(pointer, "properties");
        return failure(ErrorCode::LimitExceeded,
                       own + ": the chosen properties take " + std::to_string(size) + " bytes; the limit is " +
                           std::to_string(CarriedProperties::kMaxOfFeature),
                       own);
    }

    /// Appends underscores to a name that answers use for their own purposes, until no other property has the name.
    void make_distinct(std::string& name) const {
        if (std::ranges::find(kOwnNames, name) == kOwnNames.end()) return;
        do name += '_';
        while (numbers_.contains(name));
    }

    const PropertyChoice& choice_;
    const std::string& option_;
    CarriedProperties carried_;
    std::vector<std::string> names_;
    std::unordered_map<std::string, std::uint32_t> numbers_;
};

FeatureSource source_of(JsonValue list, std::string pointer) {
    FeatureSource source{{}, std::move(pointer)};
    for (const JsonValue feature : list) source.features.push_back(feature);
    return source;
}

/// Checks that the texts of a property could be read.
/// @param name  empty: any property
Result<void> check_readable(const FeatureSource& source, std::string_view name, const std::string& option) {
    if (!source.unreadable || !source.unreadable->is_object()) return {};
    for (const auto& [unreadable, reason] : source.unreadable->members()) {
        if (reason.is_string() && (name.empty() || name == unreadable))
            return failure(ErrorCode::Unusable, reason.text(), option);
    }
    return {};
}

}  // namespace

Result<std::vector<std::string>> read_names(const Input& input, std::size_t most, std::string_view one) {
    const auto parts = read_list(input, most, one);
    if (!parts) return tl::unexpected(parts.error());
    if (parts->empty()) return malformed(input, "must have 1 to " + std::to_string(most) + " properties");
    std::vector<std::string> names;
    for (const Input& part : *parts) {
        const auto name = read_text(part);
        if (!name) return tl::unexpected(name.error());
        if (name->empty()) return malformed(part, "must be the name of a property");
        if (std::ranges::find(names, *name) != names.end()) return malformed(part, "repeats an earlier name");
        names.emplace_back(*name);
    }
    return names;
}

Result<PropertyChoice> read_properties(const Input& input) {
    const auto* json = std::get_if<JsonValue>(&input.value);
    if (json == nullptr || json->is_string()) {
        if (trim(read_text(input).value()) == "*") return PropertyChoice{true, {}};
    }
    return read_names(input, PropertyChoice::kMax, "property").map([](std::vector<std::string>&& names) {
        return PropertyChoice{false, std::move(names)};
    });
}

std::size_t CarriedProperties::size_of(std::size_t feature) const {
    constexpr std::size_t kPunctuation = 4;
    std::size_t size = 0;
    for (const Value& value : of_feature[feature]) size += names[value.name].size() + value.value.size() + kPunctuation;
    return size;
}

void CarriedProperties::append_members(std::string& out, std::size_t feature) const {
    bool first = true;
    for (const auto& [name, is_text, value] : of_feature[feature]) {
        if (!std::exchange(first, false)) out += ',';
        append_json_text(out, names[name]);
        out += ':';
        if (is_text) {
            append_json_text(out, value);
        } else {
            out += value;
        }
    }
}

std::string FeatureSource::pointer_to(std::size_t feature) const {
    return is_collection ? pointer_below(pointer, feature) : pointer;
}

std::string FeatureList::pointer_to(std::size_t feature) const {
    return is_collection ? pointer_below(pointer, feature) : pointer;
}

Result<std::optional<JsonValue>> properties_of(JsonValue feature, const std::string& pointer) {
    const auto properties = feature.is_object() ? feature.find("properties") : std::nullopt;
    if (!properties || properties->is_null()) return std::nullopt;
    if (properties->is_object()) return properties;
    const std::string own = pointer_below(pointer, "properties");
    return failure(ErrorCode::Malformed, own + " must be an object or null", own);
}

std::optional<FeatureSource> find_features(const Input& geometry) {
    const auto value = std::get<JsonValue>(geometry.value);
    const std::string& type = value.find("type")->text();
    if (type == "Feature") return FeatureSource{{value}, geometry.field, false};
    if (type != "FeatureCollection") return std::nullopt;
    FeatureSource source = source_of(*value.find("features"), pointer_below(geometry.field, "features"));
    source.unreadable = value.find("unreadable");
    return source;
}

FeatureSource find_geometries(const Input& object) {
    const auto value = std::get<JsonValue>(object.value);
    if (const auto list = value.find("geometries")) return source_of(*list, pointer_below(object.field, "geometries"));
    return {{value}, object.field, false};
}

Result<void> check_names(const FeatureSource& source, std::span<const std::string> names, const std::string& option) {
    for (const std::string& name : names) {
        const bool is_found = std::ranges::any_of(source.features, [&](JsonValue feature) {
            const auto properties = properties_of(feature, {});
            return !properties || (*properties && (*properties)->find(name));
        });
        if (is_found) continue;
        if (auto readable = check_readable(source, name, option); !readable) return readable;
        return failure(ErrorCode::Malformed,
                       "no feature has the property '" + excerpt(name) + "'" + describe_properties(source, name),
                       option);
    }
    return {};
}

std::string describe_properties(const FeatureSource& source, std::string_view wanted) {
    std::vector<std::string> names;
    std::unordered_set<std::string> known;
    for (const JsonValue feature : source.features) {
        const auto properties = properties_of(feature, {});
        if (!properties || !*properties) continue;
        for (const auto& [name, value] : (*properties)->members()) {
            if (names.size() < PropertyChoice::kMax && known.emplace(name).second) names.emplace_back(name);
        }
    }
    if (names.empty()) return "; the features have no properties";
    const std::string* const near = wanted.empty() ? nullptr : find_similar(names, wanted);
    const std::string hint = near == nullptr ? "; the" : "; did you mean '" + excerpt(*near) + "'? The";
    return hint + " properties of the features are " + join_names(names);
}

Result<FeatureList> list_features(const FeatureSource& source, std::vector<std::size_t> first_part, std::size_t parts,
                                  const PropertyChoice* choice, const std::string& option) {
    FeatureList list;
    list.is_collection = source.is_collection;
    list.pointer = source.pointer;
    list.first_part = std::move(first_part);
    if (!list.is_collection) list.first_part = {0};
    list.first_part.push_back(parts);
    if (choice != nullptr && choice->all) {
        if (auto readable = check_readable(source, {}, option); !readable) return tl::unexpected(readable.error());
    } else if (choice != nullptr) {
        if (auto found = check_names(source, choice->names, option); !found) return tl::unexpected(found.error());
    }
    std::optional<Collector> collector;
    if (choice != nullptr) collector.emplace(*choice, option);
    for (const JsonValue feature : source.features) {
        list.ids.push_back(id_of(feature));
        if (!collector) continue;
        if (auto added = collector->add(feature, list.pointer_to(list.size() - 1)); !added)
            return tl::unexpected(added.error());
    }
    if (collector) list.carried = collector->take();
    return list;
}

Result<void> check_size(const CarriedProperties& carried, const std::vector<std::size_t>& points,
                        const std::string& option) {
    double size = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        size += static_cast<double>(points[i]) * static_cast<double>(carried.size_of(i));
    if (size <= static_cast<double>(CarriedProperties::kMaxInAll)) return {};
    return failure(ErrorCode::LimitExceeded,
                   "the properties of all points take more than " + std::to_string(CarriedProperties::kMaxInAll) +
                       " bytes: choose fewer properties or fewer points",
                   option);
}

}  // namespace ccdt::api
