#include "api/image/shades.h"

#include <cstddef>

#include "api/image/srgb.h"

namespace ccdt::api {
namespace {

std::uint8_t mix(unsigned char background, unsigned char foreground, double coverage) {
    return to_srgb((1 - coverage) * to_linear(background) + coverage * to_linear(foreground));
}

bool is_grey(const Colour& colour) {
    return !colour.transparent && colour.red == colour.green && colour.green == colour.blue;
}

}  // namespace

Shades shades_of(const Inks& inks) {
    const Colour& over = inks.foreground;
    const Colour& under = inks.background.transparent ? inks.foreground : inks.background;
    Shades shades{};
    for (std::size_t i = 0; i < shades.size(); ++i) {
        const double coverage = static_cast<double>(i) / 255;
        const auto alpha = static_cast<std::uint8_t>(inks.background.transparent ? i : 255);
        shades[i] = {mix(under.red, over.red, coverage), mix(under.green, over.green, coverage),
                     mix(under.blue, over.blue, coverage), alpha};
    }
    return shades;
}

bool are_grey(const Inks& inks) {
    return is_grey(inks.foreground) && is_grey(inks.background);
}

}  // namespace ccdt::api
