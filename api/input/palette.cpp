#include "api/input/palette.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

#include "api/text/text.h"
#include "core/halftone/separation.h"

namespace ccdt::api {
namespace {

Palette gray() {
    return {};
}

Palette cmyk() {
    return {{{"cyan", {0, 255, 255}}, {"magenta", {255, 0, 255}}, {"yellow", {255, 255, 0}}, {"black", kBlack}},
            kWhite,
            Mixing::Multiply};
}

Palette rgb() {
    return {{{"red", {255, 0, 0}}, {"green", {0, 255, 0}}, {"blue", {0, 0, 255}}}, kBlack, Mixing::Add};
}

/// Splits a palette into colours as inputs of their own; none if there are none or too many.
Result<std::vector<Input>> split(const Input& input) {
    std::vector<Input> parts;
    const auto* json = std::get_if<JsonValue>(&input.value);
    if (json != nullptr && json->is_array()) {
        if (json->size() > kMostInks) return parts;
        for (const JsonValue value : *json) {
            const std::string pointer = pointer_below(input.field, parts.size());
            parts.push_back({pointer, pointer, value});
        }
        return parts;
    }
    auto text = read_text(input);
    if (!text) return malformed(input, "must be a string or an array of strings");
    auto left = text->empty() ? 0 : static_cast<std::size_t>(std::ranges::count(*text, ',')) + 1;
    if (left > kMostInks) return parts;
    for (; left > 0; --left) {
        const std::string name = input.name + ": colour " + std::to_string(parts.size() + 1);
        parts.push_back({name, input.field, trim(take_until(*text, ","))});
    }
    return parts;
}

}  // namespace

Result<Palette> read_color(const Input& input) {
    static constexpr std::array<Choice<Palette (*)()>, 3> kPalettes = {{{"gray", gray}, {"cmyk", cmyk}, {"rgb", rgb}}};
    return read_choice<Palette (*)()>(input, kPalettes).map([](const auto make) { return make(); });
}

Result<Palette> read_palette(const Input& input) {
    const auto parts = split(input);
    if (!parts) return tl::unexpected(parts.error());
    if (parts->empty()) return malformed(input, "must have 1 to " + std::to_string(kMostInks) + " colours");
    Palette palette{{}, kWhite, Mixing::Multiply};
    for (const Input& part : *parts) {
        const auto colour = read_colour(part);
        if (!colour) return tl::unexpected(colour.error());
        const auto same = [&](const Ink& ink) { return ink.colour == *colour; };
        if (std::ranges::any_of(palette.inks, same))
            return malformed(part, "is there already: " + hexadecimal(*colour));
        palette.inks.push_back({hexadecimal(*colour), *colour});
    }
    return palette;
}

}  // namespace ccdt::api
