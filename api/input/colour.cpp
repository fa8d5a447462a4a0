// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/colour.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "api/input/colour_names.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

/// @param digits  one or two hexadecimal digits; a single digit is doubled
std::optional<unsigned char> parse_channel(std::string_view digits) {
    const auto value = parse_number<unsigned char>(digits, 16);
    return value && digits.size() == 1 ? static_cast<unsigned char>(*value * 17) : value;
}

/// Returns the value of a name of CSS as #rrggbb, and any other text unchanged.
std::string_view value_of(std::string_view text) {
    constexpr std::size_t kValue = 7;
    const bool is_word = !text.empty() && std::ranges::all_of(text, [](char c) { return c >= 'a' && c <= 'z'; });
    const std::size_t at = is_word ? kColourNames.find(' ' + std::string(text) + ' ') : std::string_view::npos;
    return at == std::string_view::npos ? text : kColourNames.substr(at + text.size() + 2, kValue);
}

std::optional<Colour> parse_colour(std::string_view text) {
    if ((text.size() != 4 && text.size() != 7) || text[0] != '#') return std::nullopt;
    const std::size_t digits = text.size() / 3;
    std::array<unsigned char, 3> channels{};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto channel = parse_channel(text.substr(1 + i * digits, digits));
        if (!channel) return std::nullopt;
        channels[i] = *channel;
    }
    return Colour{channels[0], channels[1], channels[2]};
}

}  // namespace

int squared_distance(const Colour& a, const Colour& b) {
    const int red = a.red - b.red, green = a.green - b.green, blue = a.blue - b.blue;
    return red * red + green * green + blue * blue;
}

std::string hexadecimal(const Colour& colour) {
    constexpr std::string_view kHex = "0123456789abcdef";
    std::string text = "#";
    for (const unsigned value : {colour.red, colour.green, colour.blue}) {
        text += kHex[value >> 4];
        text += kHex[value & 15];
    }
    return text;
}

Result<Colour> read_colour(const Input& input) {
    const auto text = read_text(input);
    if (!text) return tl::unexpected(text.error());
    if (const auto colour = parse_colour(value_of(*text))) return *colour;
    // In a URL, # begins the fragment, which is not sent.
    const std::string hint = text->empty() ? " (in a URL, # is written %23)" : "";
    return malformed(input, "must be a colour: #rgb, #rrggbb or a name of CSS such as teal" + hint);
}

Result<std::vector<Colour>> read_colours(const Input& input, std::size_t min, std::size_t max) {
    const auto parts = read_list(input, max, "colour");
    if (!parts) return tl::unexpected(parts.error());
    if (parts->size() < min)
        return malformed(input, "must have " + std::to_string(min) + " to " + std::to_string(max) + " colours");
    std::vector<Colour> colours;
    for (const Input& part : *parts) {
        const auto colour = read_colour(part);
        if (!colour) return tl::unexpected(colour.error());
        if (std::ranges::find(colours, *colour) != colours.end())
            return malformed(part, "repeats an earlier colour: " + hexadecimal(*colour));
        colours.push_back(*colour);
    }
    return colours;
}

Result<Colour> read_colour_or_none(const Input& input) {
    const auto text = read_text(input);
    if (text && *text == "transparent") return Colour{.transparent = true};
    return read_colour(input);
}

}  // namespace ccdt::api
