// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/shades.h"

#include <cstddef>

#include "api/image/srgb.h"

namespace ccdt::api {
namespace {

std::uint8_t mix(unsigned char paper, unsigned char ink, double coverage) {
    return to_srgb((1 - coverage) * to_linear(paper) + coverage * to_linear(ink));
}

}  // namespace

Shades shades_of(const Colour& ink, const Colour& paper) {
    const Colour& under = paper.transparent ? ink : paper;
    Shades shades{};
    for (std::size_t i = 0; i < shades.size(); ++i) {
        const double coverage = static_cast<double>(i) / 255;
        const auto alpha = static_cast<std::uint8_t>(paper.transparent ? i : 255);
        shades[i] = {mix(under.red, ink.red, coverage), mix(under.green, ink.green, coverage),
                     mix(under.blue, ink.blue, coverage), alpha};
    }
    return shades;
}

}  // namespace ccdt::api
