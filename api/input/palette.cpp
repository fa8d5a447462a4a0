// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/palette.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

#include "core/halftone/inks/separation.h"

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

bool has_sets(const Palette& palette) {
    return palette.mixing == Mixing::Multiply && !is_cmyk(palette.inks);
}

Result<Palette> read_color(const Input& input) {
    static constexpr std::array<Choice<Palette (*)()>, 3> kPalettes = {{{"gray", gray}, {"cmyk", cmyk}, {"rgb", rgb}}};
    return read_choice<Palette (*)()>(input, kPalettes).map([](const auto make) { return make(); });
}

Result<Palette> read_palette(const Input& input) {
    const auto colours = read_colours(input, 1, kMaxInks);
    if (!colours) return tl::unexpected(colours.error());
    Palette palette{{}, kWhite, Mixing::Multiply};
    for (const Colour& colour : *colours) palette.inks.push_back({hexadecimal(colour), colour});
    return palette;
}

}  // namespace ccdt::api
