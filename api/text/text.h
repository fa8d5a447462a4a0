// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace ccdt::api {

/// Removes the characters in `blanks` from both ends of a text.
inline std::string_view trim(std::string_view text, std::string_view blanks = " \t") {
    const auto first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// Whether a text may be meant as JSON: it begins with an object or an array.
/// @param blanks  characters that may precede
inline bool begins_like_json(std::string_view text, std::string_view blanks = " \t\r\n") {
    const auto start = trim(text, blanks);
    return start.starts_with('{') || start.starts_with('[');
}

/// Removes from `text` the part before the first separator, and the separator. Returns this part. If there is no
/// separator, the part is the whole text.
inline std::string_view take_until(std::string_view& text, std::string_view separator) {
    const auto at = text.find(separator);
    const auto part = text.substr(0, at);
    text.remove_prefix(at == std::string_view::npos ? text.size() : at + separator.size());
    return part;
}

/// Returns a text with small instead of capital letters of ASCII.
inline std::string in_small_letters(std::string_view text) {
    std::string small(text);
    for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return small;
}

/// Parses a text that consists of one number, independently of the locale. Returns none for any other text.
/// @param form  base of an integer, or std::chars_format of a floating-point number
template <class T, class... Form>
std::optional<T> parse_number(std::string_view text, Form... form) {
    T value{};
    const char* const end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, value, form...);
    if (error != std::errc() || stopped != end) return std::nullopt;
    return value;
}

/// Returns whether a text is safe in headers, logs and labels: it has only letters, digits, dots, underscores and
/// dashes, and is neither empty nor longer than `longest`.
inline bool is_plain_name(std::string_view text, std::size_t longest) {
    const auto is_plain = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '_' ||
               c == '-';
    };
    return !text.empty() && text.size() <= longest && std::ranges::all_of(text, is_plain);
}

}  // namespace ccdt::api
