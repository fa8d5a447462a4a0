// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/palette.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

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

}  // namespace

bool is_cmyk(std::span<const Ink> inks) {
    return std::ranges::equal(inks, cmyk().inks, {}, &Ink::colour, &Ink::colour);
}

Result<Palette> read_color(const Input& input) {
    static constexpr std::array<Choice<Palette (*)()>, 3> kPalettes = {{{"gray", gray}, {"cmyk", cmyk}, {"rgb", rgb}}};
    return read_choice<Palette (*)()>(input, kPalettes).map([](const auto make) { return make(); });
}

Result<Palette> read_palette(const Input& input) {
    const auto parts = read_list(input, kMaxInks, "colour");
    if (!parts) return tl::unexpected(parts.error());
    if (parts->empty()) return malformed(input, "must have 1 to " + std::to_string(kMaxInks) + " colours");
    Palette palette{{}, kWhite, Mixing::Multiply};
    for (const Input& part : *parts) {
        const auto colour = read_colour(part);
        if (!colour) return tl::unexpected(colour.error());
        const auto same = [&](const Ink& ink) { return ink.colour == *colour; };
        if (std::ranges::any_of(palette.inks, same))
            return malformed(part, "repeats an earlier colour: " + hexadecimal(*colour));
        palette.inks.push_back({hexadecimal(*colour), *colour});
    }
    return palette;
}

}  // namespace ccdt::api
