// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/reference_system.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "api/text/byte_order_mark.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

constexpr auto kOfProjected = std::to_array<std::string_view>({"projcs", "projcrs", "projectedcrs"});
constexpr auto kOfGeographic =
    std::to_array<std::string_view>({"geogcs", "geogcrs", "geographiccrs", "geodcrs", "geodeticcrs"});

/// Removes from a text everything up to the next keyword, its bracket included. Returns the keyword in small letters;
/// empty if there is none. Skips texts in quotes.
std::string take_keyword(std::string_view& text) {
    while (!text.empty()) {
        const std::size_t end = std::min(text.find_first_of("[(,\")]"), text.size() - 1);
        const std::string_view word = trim(text.substr(0, end), kBlanks);
        const char mark = text[end];
        text.remove_prefix(end + 1);
        if (mark == '"') take_until(text, "\"");
        if ((mark == '[' || mark == '(') && !word.empty()) return in_small_letters(word);
    }
    return {};
}

/// Removes the text in quotes at the start of a text. Returns it without the quotes.
std::string_view take_quoted(std::string_view& text) {
    text = trim(text, kBlanks);
    if (!text.starts_with('"')) return {};
    text.remove_prefix(1);
    return take_until(text, "\"");
}

/// Whether one of the units that a text declares is the degree. Heights may have other units. Without any unit, the
/// unit of angles is the degree.
bool is_in_degrees(std::string_view text) {
    constexpr double kDegree = std::numbers::pi / 180, kTolerance = 1e-6;
    bool has_unit = false;
    for (std::string word = take_keyword(text); !word.empty(); word = take_keyword(text)) {
        if (word != "unit" && word != "angleunit") continue;
        has_unit = true;
        take_quoted(text);
        std::string_view rest = text;
        take_until(rest, ",");
        const auto radians = parse_number<double>(trim(rest.substr(0, rest.find_first_of(",])")), kBlanks));
        if (radians && std::abs(*radians - kDegree) <= kTolerance) return true;
    }
    return !has_unit;
}

std::optional<ReferenceSystem> recognise_wkt(std::string_view text) {
    for (std::string word = take_keyword(text); !word.empty(); word = take_keyword(text)) {
        const bool is_projected = std::ranges::count(kOfProjected, word) > 0;
        if (!is_projected && std::ranges::count(kOfGeographic, word) == 0) continue;
        ReferenceSystem system{std::string(take_quoted(text)), false};
        system.is_lonlat = !is_projected && is_in_degrees(text);
        return system;
    }
    return std::nullopt;
}

/// Recognises a code of EPSG, or a name of OGC, at the end of a name.
std::optional<ReferenceSystem> recognise_name(std::string_view name) {
    constexpr auto kLonLat = std::to_array<std::string_view>({"CRS84", "CRS83", "CRS27", "4326", "4258", "4269"});
    constexpr int kWebMercator = 3857;
    const std::string_view code = name.substr(name.find_last_of(":/#") + 1);
    if (std::ranges::count(kLonLat, code) > 0) return ReferenceSystem{std::string(name), true};
    const int number = parse_number<int>(code).value_or(0);
    // Ranges of EPSG.
    const bool is_projected =
        number == kWebMercator || (number >= 2000 && number < 3800) || (number >= 20'000 && number < 33'000);
    return is_projected ? std::optional(ReferenceSystem{std::string(name), false}) : std::nullopt;
}

}  // namespace

std::optional<ReferenceSystem> recognise_reference_system(std::string_view description) {
    description = trim(without_byte_order_mark(description), kBlanks);
    return description.find_first_of("[(") == std::string_view::npos ? recognise_name(description)
                                                                     : recognise_wkt(description);
}

}  // namespace ccdt::api
