// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/dither.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "core/dither/device_colours.h"
#include "core/dither/device_gamut.h"
#include "core/dither/direct_search.h"
#include "core/halftone/colour_table.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/srgb.h"

namespace ccdt {

namespace {

float luminance_of_colour(const Light& light) {
    return luminance_of(light.red, light.green, light.blue);
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

}  // namespace

std::vector<std::uint8_t> dither(const LightPlanes& light, std::span<const std::uint8_t> given, int width, int height,
                                 std::span<const Light> colours, const std::stop_token& stop, Executor& executor) {
    const DeviceColours device(colours);
    assert(light.front().size() == given.size());
    std::vector<DeviceColours::Opponent> wanted(given.size());
    RangeMap map(colours);
    for_pixels(executor, wanted.size(), [&](std::size_t i) {
        const Light own = light_at(light, i);
        wanted[i] = given[i] != kAnyColour ? device[given[i]]
                                           : DeviceColours::opponent(device.is_grey() ? map.grey(own) : map(own));
    });
    std::vector<std::uint8_t> chosen = diffuse_error(wanted, given, width, height, device);
    return search_directly(wanted, given, std::move(chosen), width, height, device, {}, stop, executor);
}

}  // namespace ccdt
