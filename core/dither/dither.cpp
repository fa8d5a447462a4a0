// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/dither.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "core/dither/device_colours.h"
#include "core/dither/device_gamut.h"
#include "core/dither/direct_search.h"
#include "core/dither/printed_spot.h"
#include "core/dither/spot_search.h"
#include "core/dither/visual_error.h"
#include "core/halftone/inks/colour_table.h"
#include "core/picture/pixel_ranges.h"
#include "core/picture/srgb.h"

namespace ccdt {

namespace {

float luminance_of_colour(const Light& light) {
    return luminance_of(light.red, light.green, light.blue);
}

/// Returns a mixture of two colours. `share` is the share of the second colour.
Light mixture(const Light& a, const Light& b, float share) {
    return {std::lerp(a.red, b.red, share), std::lerp(a.green, b.green, share), std::lerp(a.blue, b.blue, share)};
}

/// Maps the colours of pictures to colours that mixtures of a device's colours can make.
class RangeMap {
public:
    explicit RangeMap(std::span<const Light> colours)
        : dark_(*std::ranges::min_element(colours, {}, [](const Light& light) { return luminance_of_colour(light); })),
          light_(*std::ranges::max_element(colours, {}, [](const Light& light) { return luminance_of_colour(light); })),
          gamut_(colours),
          excess_([this](const Light& light) { return excess_at(light); }, Steps::Lightness) {}

    /// Maps a colour for a device that has only greys.
    Light grey(const Light& light) const {
        const float value = luminance_of_colour(light);
        return scaled({value, value, value});
    }

    /// @param light  in [0, 1]
    Light operator()(const Light& light) {
        const Light wanted = scaled(light);
        const Excess excess = excess_(light);
        return {wanted.red + excess[0], wanted.green + excess[1], wanted.blue + excess[2]};
    }

private:
    /// Nearest colour of the gamut minus wanted colour: 0 within the gamut, so such colours are exact.
    using Excess = std::array<float, 3>;

    Light scaled(const Light& light) const {
        return {std::lerp(dark_.red, light_.red, light.red), std::lerp(dark_.green, light_.green, light.green),
                std::lerp(dark_.blue, light_.blue, light.blue)};
    }

    Excess excess_at(const Light& light) const {
        const Light wanted = scaled(light), nearest = gamut_.nearest(wanted);
        return {nearest.red - wanted.red, nearest.green - wanted.green, nearest.blue - wanted.blue};
    }

    Light dark_, light_;
    DeviceGamut gamut_;
    ColourTable<Excess> excess_;
};

/// Returns the number of the darkest colour.
std::size_t darkest(std::span<const Light> colours) {
    return static_cast<std::size_t>(std::ranges::min_element(colours, {}, luminance_of_colour) - colours.begin());
}

/// Chooses the colours of pixels for a device with two colours, of which the darker one prints spots.
/// @param wanted  [width * height] mixtures of the two colours of `device`, which are the lighter colour and the
///                darkest print
std::vector<std::uint8_t> choose_spots(std::span<const DeviceColours::Opponent> wanted,
                                       std::span<const std::uint8_t> given, int width, int height,
                                       const DeviceColours& device, std::size_t dark, const PrintedSpot& spot,
                                       const std::stop_token& stop, Executor& executor) {
    const auto product = [](const DeviceColours::Opponent& a, const DeviceColours::Opponent& b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    };
    const std::size_t light = 1 - dark;
    DeviceColours::Opponent axis{};
    for (std::size_t c = 0; c < axis.size(); ++c) axis[c] = device[dark][c] - device[light][c];
    const float scale = spot.solid() / product(axis, axis);
    std::vector<float> covered(wanted.size());
    std::vector<std::uint8_t> is_dark(given.begin(), given.end());
    for_pixels(executor, wanted.size(), [&](std::size_t i) {
        covered[i] = scale * (product(wanted[i], axis) - product(device[light], axis));
        if (given[i] != kAnyColour) is_dark[i] = given[i] == dark ? 1 : 0;
    });
    std::vector<std::uint8_t> chosen = search_spots(covered, is_dark, width, height, spot, stop, executor);
    for (std::uint8_t& pixel : chosen) pixel = static_cast<std::uint8_t>(pixel == 1 ? dark : light);
    return chosen;
}

}  // namespace

std::vector<std::uint8_t> dither(const LightPlanes& light, std::span<const std::uint8_t> given, int width, int height,
                                 std::span<const Light> colours, double diameter, const std::stop_token& stop,
                                 Executor& executor) {
    assert(light.front().size() == given.size());
    assert(diameter == 0 || colours.size() == 2);
    const std::size_t dark = darkest(colours);
    std::vector<Light> seen(colours.begin(), colours.end());
    std::optional<PrintedSpot> spot;
    if (diameter > 0) {
        spot.emplace(diameter);
        seen[dark] = mixture(colours[1 - dark], colours[dark], spot->solid());
    }
    const DeviceColours device(seen);
    std::vector<DeviceColours::Opponent> wanted(given.size());
    RangeMap map(seen);
    for_pixels(executor, wanted.size(), [&](std::size_t i) {
        const Light own = light_at(light, i);
        wanted[i] = given[i] != kAnyColour ? device[given[i]]
                                           : DeviceColours::opponent(device.is_grey() ? map.grey(own) : map(own));
    });
    if (spot) return choose_spots(wanted, given, width, height, device, dark, *spot, stop, executor);
    std::vector<std::uint8_t> chosen = diffuse_error(wanted, given, width, height, device);
    const std::span<const double> blurs = device.is_grey() ? std::span<const double>(kGreyBlurs) : kColourBlurs;
    for (const double blur : blurs)
        chosen =
            search_directly(wanted, given, std::move(chosen), width, height, device, {.blur = blur}, stop, executor);
    return chosen;
}

}  // namespace ccdt
