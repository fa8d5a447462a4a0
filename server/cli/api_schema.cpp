// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/api_schema.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "api/json/json_document.h"
#include "api/run/options.h"
#include "api/text/numbers.h"
#include "api/text/text.h"

namespace ccdt::server {
namespace {

using api::JsonValue;

/// Finds schemas in a description of an API.
class Schemas {
public:
    explicit Schemas(JsonValue document) : document_(document) {}

    /// Returns the value at a JSON Pointer with a leading `#`. It must exist, because openapi.json is part of the
    /// build.
    JsonValue at(std::string_view reference) const {
        reference.remove_prefix(std::string_view("#/").size());
        JsonValue value = document_;
        while (!reference.empty()) value = value.find(api::take_until(reference, "/")).value();
        return value;
    }

    /// Finds a keyword in a schema, or in the schema to which it refers.
    std::optional<JsonValue> find(JsonValue schema, std::string_view keyword) const {
        if (const auto own = schema.find(keyword)) return own;
        const auto reference = schema.find("$ref");
        return reference ? find(at(reference->text()), keyword) : std::nullopt;
    }

private:
    JsonValue document_;
};

std::string text_of(JsonValue value) {
    if (value.is_string()) return value.text();
    std::string text;
    api::append_json(text, value);
    return text;
}

/// Describes the range of a number.
std::string range_of(const Schemas& schemas, JsonValue schema) {
    const auto bound = [&](std::string_view keyword) -> std::string {
        const auto value = schemas.find(schema, keyword);
        if (!value) return {};
        // The maximum number of sites is a setting.
        if (value->number() == static_cast<double>(api::Limits().max_sites)) return "--max-sites";
        return text_of(*value);
    };
    const std::string low = bound("minimum"), above = bound("exclusiveMinimum"), high = bound("maximum");
    if (!low.empty() && !high.empty()) return "from " + low + " to " + high;
    if (!low.empty()) return "at least " + low;
    if (above.empty()) return {};
    return "above " + above + (high.empty() ? "" : ", at most " + high);
}

void add_words(Option& option, const std::vector<std::string>& words) {
    for (const std::string& word : words) {
        if (std::ranges::find(option.words, word) == option.words.end()) option.words.push_back(word);
    }
}

/// Adds the values that a schema accepts to those of an option.
void add_values(const Schemas& schemas, JsonValue schema, Option& option) {
    for (const std::string_view choice : {"anyOf", "oneOf"}) {
        const auto alternatives = schemas.find(schema, choice);
        if (!alternatives) continue;
        for (const JsonValue alternative : *alternatives) {
            if (alternative.find("required") && !alternative.find("type")) continue;  // restricts the type beside it
            add_values(schemas, alternative, option);
        }
    }
    const auto type = schemas.find(schema, "type");
    if (!type) return;
    const std::string& name = type->text();
    if (name == "integer" || name == "number") {
        option.takes_number = true;
        if (option.value.empty()) option.value = name == "integer" ? "N" : "NUMBER";
        if (option.allowed.empty()) option.allowed = range_of(schemas, schema);
        if (const auto words = schemas.find(schema, "enum")) {
            for (const JsonValue word : *words) add_words(option, {text_of(word)});
        }
    } else if (name == "array" || name == "object") {
        option.takes_json = true;
        if (option.value.empty()) option.value = "JSON";
    } else if (name == "string") {
        if (const auto words = schemas.find(schema, "enum")) {
            for (const JsonValue word : *words) add_words(option, {word.text()});
        } else if (const auto constant = schemas.find(schema, "const")) {
            add_words(option, {constant->text()});
        } else {
            option.takes_text = true;
            const auto reference = schema.find("$ref");
            const bool is_colour = reference && reference->text().ends_with("/Colour");
            const bool is_file = option.value.empty() && schemas.find(schema, "format").has_value();
            if (option.value.empty() || option.value == "JSON")
                option.value = is_colour ? "COLOUR" : is_file ? "FILE" : "TEXT";
        }
    }
}

/// Names the values of an option that accepts only a few words.
void name_words(Option& option) {
    constexpr std::size_t kLongest = 40;
    if (option.words.empty() || option.takes_text || (option.takes_number && !option.allowed.empty())) return;
    std::string all;
    for (const std::string& word : option.words) all.append(all.empty() ? "" : "|").append(word);
    option.value = std::move(all);
    if (option.value.size() <= kLongest) return;
    option.value = option.member;
    std::ranges::transform(option.value, option.value.begin(), [](unsigned char c) { return std::toupper(c); });
}

Option read_option(const Schemas& schemas, std::string_view member, JsonValue schema) {
    Option option{.name = hyphenated(member), .member = std::string(member)};
    add_values(schemas, schema, option);
    if (const auto text = schemas.find(schema, "description")) option.description = text->text();
    if (const auto value = schemas.find(schema, "default")) option.default_value = text_of(*value);
    return option;
}

void add_option(Option option, std::vector<Option>& options) {
    const auto same = std::ranges::find(options, option.member, &Option::member);
    if (same == options.end())
        options.push_back(std::move(option));
    else
        add_words(*same, option.words);
}

/// @param reference  reference to a schema of an object
void add_properties(const Schemas& schemas, std::string_view reference, std::vector<Option>& options) {
    const JsonValue schema = schemas.at(reference);
    if (const auto parts = schema.find("allOf")) {
        for (const JsonValue part : *parts) add_properties(schemas, part.find("$ref")->text(), options);
    }
    for (const auto& [name, value] : schema.find("properties")->members()) {
        Option option = read_option(schemas, name, value);
        option.in_body = reference.ends_with("Request");
        add_option(std::move(option), options);
    }
}

/// Replaces the names of members in a text by the names of the options.
void name_options(const std::vector<Option>& options, std::string& text) {
    for (const Option& option : options) {
        if (option.member == option.name) continue;
        for (std::size_t at = 0; (at = text.find(option.member, at)) != std::string::npos; at += option.name.size())
            text.replace(at, option.member.size(), option.name);
    }
}

}  // namespace

std::vector<Option> read_options(std::span<const std::string_view> schemas) {
    const auto document = api::JsonDocument::parse(api_files().front().content).value();
    const Schemas all(document.root());
    std::vector<Option> options;
    for (const std::string_view name : schemas)
        add_properties(all, "#/components/schemas/" + std::string(name), options);
    for (Option& option : options) {
        name_words(option);
        name_options(options, option.description);
    }
    return options;
}

}  // namespace ccdt::server
