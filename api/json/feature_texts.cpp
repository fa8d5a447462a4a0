// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/json/feature_texts.h"

#include <algorithm>

#include "api/text/byte_order_mark.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kBlanks = " \t\r\n", kBetweenTexts = " \t\r\n\x1E";

std::size_t skip(std::string_view text, std::size_t at, std::string_view blanks = kBlanks) {
    return std::min(text.find_first_not_of(blanks, at), text.size());
}

/// Returns the character at a position; NUL after the end.
char at_or_nul(std::string_view text, std::size_t at) {
    return at < text.size() ? text[at] : '\0';
}

/// Returns the position after a string; `text.size()` if it has no end.
/// @param at  position of the quote at its start
std::size_t end_of_string(std::string_view text, std::size_t at) {
    while ((at = text.find_first_of("\"\\", at + 1)) != std::string_view::npos) {
        if (text[at] == '"') return at + 1;
        ++at;  // the character after a backslash
    }
    return text.size();
}

/// Returns the position after an object, an array or another value.
std::size_t end_of_value(std::string_view text, std::size_t at) {
    std::size_t depth = 0;
    do {
        const char c = at_or_nul(text, at);
        if (c == '"') {
            at = end_of_string(text, at);
        } else if (c == '{' || c == '[') {
            ++depth;
            ++at;
        } else if (c == '}' || c == ']') {
            if (depth == 0) return at;
            --depth;
            ++at;
        } else {
            at = std::min(text.find_first_of(depth == 0 ? ",]} \t\r\n" : "\"{}[]", at), text.size());
        }
    } while (depth > 0 && at < text.size());
    return at;
}

/// Returns the position of the bracket at the start of the member `features` of an object; none if there is none.
/// @param at  position of the brace at the start of the object
std::optional<std::size_t> find_list(std::string_view text, std::size_t at) {
    do {
        const std::size_t name = skip(text, at + 1);
        if (at_or_nul(text, name) != '"') return std::nullopt;
        const std::size_t after = end_of_string(text, name), colon = skip(text, after), value = skip(text, colon + 1);
        if (at_or_nul(text, colon) != ':') return std::nullopt;
        if (text.substr(name, after - name) == "\"features\"" && at_or_nul(text, value) == '[') return value;
        at = skip(text, end_of_value(text, value));
    } while (at_or_nul(text, at) == ',');
    return std::nullopt;
}

/// Finds the elements of an array.
/// @param at  position of the bracket at its start
std::optional<FeatureTexts> find_elements(std::string_view text, std::size_t at) {
    FeatureTexts found{{}, TextRange{at + 1, at + 1}};
    at = skip(text, at + 1);
    if (at_or_nul(text, at) == ']') return found;
    while (true) {
        const std::size_t end = end_of_value(text, at);
        if (end == at) return std::nullopt;
        found.features.push_back({at, end});
        at = skip(text, end);
        if (at_or_nul(text, at) == ']') break;
        if (at_or_nul(text, at) != ',') return std::nullopt;
        at = skip(text, at + 1);
    }
    found.list->end = at;
    return found;
}

}  // namespace

std::optional<FeatureTexts> find_features(std::string_view text) {
    std::size_t at = skip(text, text.size() - without_byte_order_mark(text).size(), kBetweenTexts);
    if (at_or_nul(text, at) != '{') return std::nullopt;
    if (const auto list = find_list(text, at)) return find_elements(text, *list);
    FeatureTexts found;
    for (; at < text.size(); at = skip(text, found.features.back().end, kBetweenTexts)) {
        if (text[at] != '{') return std::nullopt;
        found.features.push_back({at, end_of_value(text, at)});
    }
    return found;
}

}  // namespace ccdt::api
