// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/error_diffusion.h"

namespace ccdt {

std::vector<std::uint8_t> diffuse_error(std::span<const DeviceColours::Opponent> wanted,
                                        std::span<const std::uint8_t> given, int width, int height,
                                        const DeviceColours& device) {
    std::vector<std::uint8_t> chosen(given.begin(), given.end());
    diffuse<DeviceColours::Opponent>(
        given, width, height, [&](std::size_t pixel) { return wanted[pixel]; },
        [&](std::size_t pixel, const DeviceColours::Opponent& value) {
            chosen[pixel] = static_cast<std::uint8_t>(device.nearest(value));
            return device[chosen[pixel]];
        });
    return chosen;
}

}  // namespace ccdt
