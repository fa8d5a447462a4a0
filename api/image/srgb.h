// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace ccdt::api {

/// Returns the linear light, 0 to 1, of an sRGB value (IEC 61966-2-1).
double to_linear(unsigned char value);

/// Returns the sRGB value that is nearest to an amount of linear light, which is clamped to [0, 1].
std::uint8_t to_srgb(double light);

}  // namespace ccdt::api
