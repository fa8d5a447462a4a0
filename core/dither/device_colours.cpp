// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/device_colours.h"

#include <cassert>
#include <limits>

#include "core/picture/colour_difference.h"

namespace ccdt {

DeviceColours::DeviceColours(std::span<const Light> colours) {
    assert(colours.size() >= 2 && colours.size() <= kMaxDeviceColours);
    for (const Light& light : colours) {
        colours_.push_back(opponent(light));
        is_grey_ = is_grey_ && light.red == light.green && light.green == light.blue;
    }
    if (!is_grey_) return;
    for (Opponent& colour : colours_) colour[1] = colour[2] = 0;  // removes rounding errors
}

std::size_t DeviceColours::nearest(const Opponent& colour) const {
    std::size_t best = 0;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t number = 0; number < colours_.size(); ++number) {
        float distance = 0;
        for (std::size_t c = 0; c < colour.size(); ++c) {
            const float difference = colour[c] - colours_[number][c];
            distance += difference * difference;
        }
        if (distance < least) {
            least = distance;
            best = number;
        }
    }
    return best;
}

DeviceColours::Opponent DeviceColours::opponent(const Light& light) {
    // CIELAB has the axes 116 f(Y), 500 (f(X) - f(Y)), 200 (f(Y) - f(Z)). The opponent space has f(t) = t / 116.
    constexpr double kRedGreen = 500.0 / 116, kBlueYellow = 200.0 / 116;
    std::array<double, 3> xyz{};
    for (std::size_t i = 0; i < xyz.size(); ++i)
        xyz[i] = kLightToXyz[i][0] * light.red + kLightToXyz[i][1] * light.green + kLightToXyz[i][2] * light.blue;
    return {static_cast<float>(xyz[1]), static_cast<float>(kRedGreen * (xyz[0] - xyz[1])),
            static_cast<float>(kBlueYellow * (xyz[1] - xyz[2]))};
}

}  // namespace ccdt
