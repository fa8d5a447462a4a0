// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/srgb.h"

#include <algorithm>
#include <cmath>

#include "core/picture/srgb.h"

namespace ccdt::api {

double to_linear(unsigned char value) {
    return light_of_srgb(value / 255.0);
}

std::uint8_t to_srgb(double light) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(srgb_of_light(light), 0.0, 1.0)));
}

}  // namespace ccdt::api
