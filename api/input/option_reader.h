// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/json/json_document.h"
#include "api/run/options.h"
#include "core/base/result.h"

namespace ccdt::api {

/// A value of a request: the text of a query parameter or form field, or a JSON value.
struct Input {
    std::string name;   ///< name of the value in messages
    std::string field;  ///< value of Error::field: the name of an option given as text, otherwise a JSON Pointer
    std::variant<std::string_view, JsonValue> value;
};

/// Largest integer n for which doubles, and thus JSON numbers, represent both n and n + 1 exactly.
inline constexpr std::uint64_t kMaxInteger = (std::uint64_t{1} << 53) - 1;

/// Range of finite numbers that an option may take.
struct Interval {
    double min = 0;
    double max = std::numeric_limits<double>::max();
    bool above_min = false;  ///< whether min itself is excluded
};

/// Range of positive, finite numbers.
inline constexpr Interval kPositive = {.min = 0, .above_min = true};

/// Reads a number. The input must be a JSON number, or a text that consists of one number. read_integer() rejects
/// fractions. Errors: Malformed; the message states the allowed values.
Result<std::uint64_t> read_integer(const Input& input, std::uint64_t min, std::uint64_t max);
Result<double> read_number(const Input& input, const Interval& allowed);

/// Reads `true` or `false`. As text, `1` and `0` are also accepted.
Result<bool> read_boolean(const Input& input);

/// Reads text, such as a word, a colour or base64. The result refers to memory of the input.
Result<std::string_view> read_text(const Input& input);

/// Parses text that is JSON. Errors: Malformed.
Result<JsonDocument> parse_json(const Input& input);

/// Converts an error about the contents of a body to one about an option whose text was read like a body. The message
/// may begin with a JSON Pointer in the text.
Error error_in_text(Error error, const Input& input);

/// Parses text that is a list in JSON. Errors: Malformed.
Result<JsonDocument> parse_list(const Input& input);

/// Reads a list: text with commas between its members, or a JSON array. Errors: Malformed for any other type of value.
/// @param most  maximum number of members
/// @param one   noun for a member in messages, such as "colour"; used for members that are given as text
/// @returns     an input for each member; empty if there are no members or more than `most`. The caller then reports
///              the allowed number.
Result<std::vector<Input>> read_list(const Input& input, std::size_t most, std::string_view one);

/// Reads one of the given words.
/// @returns  index of the word
Result<std::size_t> read_word(const Input& input, std::span<const std::string_view> words);

/// A word that an option accepts, and its value.
template <class T>
struct Choice {
    std::string_view word;
    T value;
};

/// Reads one of the given words.
/// @returns  value of the word
template <class T>
Result<T> read_choice(const Input& input, std::span<const Choice<T>> choices) {
    std::vector<std::string_view> words;
    for (const auto& choice : choices) words.push_back(choice.word);
    return read_word(input, words).map([&](std::size_t i) { return choices[i].value; });
}

/// Reads a number of sites or points.
/// Errors: Malformed; LimitExceeded above limits.max_sites, with this limit in the message.
Result<std::size_t> read_sites(const Input& input, const Limits& limits);

/// Returns a Malformed error about an input. The message is the name of the input, then `what`.
tl::unexpected<Error> malformed(const Input& input, std::string_view what);

/// Converts an error of core about a part of a request to an error about the whole request. The field of the error is
/// the name of a member of this part, or a JSON Pointer relative to the part. It becomes a JSON Pointer in the request.
/// @param pointer  JSON Pointer to the part
Error error_below(Error error, std::string_view pointer);

/// Shortens text from a client to its first 64 bytes, for use in messages. Control characters become spaces.
std::string excerpt(std::string_view text);

/// Lists names from a client, for use in messages: excerpts of the first ten, with commas between them.
std::string join_names(std::span<const std::string> names);

/// Lists options that are given as text. The inputs refer to memory of the options.
std::vector<Input> inputs_of(const std::vector<TextOption>& options);

/// Lists the members of a JSON object.
/// @param pointer  JSON Pointer to the object; empty for the whole body
/// Errors: Malformed for a value that is not an object, and for an object with more than 64 members.
Result<std::vector<Input>> inputs_of(JsonValue object, std::string_view pointer);

/// Collects the errors in a request, so that one answer reports all of them.
class ErrorList {
public:
    template <class T>
    void add(const Result<T>& result) {
        if (!result) add(result.error());
    }

    /// Returns the first error, with the other errors in its list `others`; success if there are no errors.
    Result<void> result() const;

private:
    void add(const Error& error);

    std::optional<Error> first_;
};

/// Name of an option, and the function that reads the option into a target.
template <class Target>
struct OptionRule {
    std::string_view name;
    Result<void> (*read)(const Input& input, const Limits& limits, Target& target);
};

/// Returns rules one after another.
template <class Target, std::size_t... kSizes>
constexpr auto joined(const std::array<OptionRule<Target>, kSizes>&... rules) {
    std::array<OptionRule<Target>, (kSizes + ...)> all;
    auto next = all.begin();
    ((next = std::ranges::copy(rules, next).out), ...);
    return all;
}

/// Stores a value in `target`. If there is an error instead of a value, returns the error.
template <class T, class Value>
Result<void> assign(T& target, Result<Value> value) {
    if (!value) return tl::unexpected(value.error());
    target = static_cast<T>(*std::move(value));
    return {};
}

/// Returns a Malformed error about an input whose name is not in `known`.
tl::unexpected<Error> unknown_option(const Input& input, std::span<const std::string_view> known);

/// Returns the names of the options that the rules read.
template <class Target>
std::vector<std::string_view> names_of(std::span<const OptionRule<Target>> rules) {
    std::vector<std::string_view> names;
    for (const auto& rule : rules) names.push_back(rule.name);
    return names;
}

/// Reads an input by the rule that has its name.
/// @param before  inputs that precede this one in the request
/// Errors: Malformed for a name without a rule, or for the name of an earlier input; those of the rule.
template <class Target>
Result<void> read_option(std::span<const OptionRule<Target>> rules, std::span<const Input> before, const Input& input,
                         const Limits& limits, Target& target) {
    const auto named_alike = [&](const auto& other) { return other.name == input.name; };
    const auto rule = std::find_if(rules.begin(), rules.end(), named_alike);
    if (rule == rules.end()) return unknown_option(input, names_of(rules));
    if (std::any_of(before.begin(), before.end(), named_alike)) return malformed(input, "is given twice");
    return rule->read(input, limits, target);
}

/// Reads every input by the rule that has its name, in order, and continues after errors.
/// Errors: Malformed for a name without a rule, or for a repeated name; those of the rules.
template <class Target>
Result<void> read_options(std::span<const OptionRule<Target>> rules, std::span<const Input> inputs,
                          const Limits& limits, Target& target) {
    ErrorList errors;
    for (std::size_t i = 0; i < inputs.size(); ++i)
        errors.add(read_option(rules, inputs.first(i), inputs[i], limits, target));
    return errors.result();
}

/// Reads every input by the rule that has its name. Errors: those of read_options(); Malformed if the input `required`
/// is missing.
template <class Target>
Result<void> read_options(std::span<const OptionRule<Target>> rules, std::span<const Input> inputs,
                          std::string_view required, const Limits& limits, Target& target) {
    ErrorList errors;
    errors.add(read_options(rules, inputs, limits, target));
    if (std::ranges::find(inputs, required, &Input::name) == inputs.end())
        errors.add(
            Result<void>(failure(ErrorCode::Malformed, std::string(required) + " is missing", std::string(required))));
    return errors.result();
}

/// Reads the members of a JSON object as options.
/// @param pointer  JSON Pointer to the object; empty for the whole body
template <class Target>
Result<void> read_members(std::span<const OptionRule<Target>> rules, JsonValue object, std::string_view pointer,
                          const Limits& limits, Target& target) {
    const auto inputs = inputs_of(object, pointer);
    if (!inputs) return tl::unexpected(inputs.error());
    return read_options(rules, *inputs, limits, target);
}

/// Reads a body that is a JSON object of options. The parsed JSON is destroyed afterwards, so rules must copy the
/// values that they keep. Errors: those of JsonDocument::parse and read_options().
template <class Target>
Result<void> read_body(std::span<const OptionRule<Target>> rules, std::string_view body, const Limits& limits,
                       Target& target) {
    const auto document = JsonDocument::parse(body);
    if (!document) return tl::unexpected(document.error());
    return read_members(rules, document->root(), "", limits, target);
}

}  // namespace ccdt::api
