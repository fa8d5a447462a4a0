#pragma once

#include <cstdint>

namespace ccdt::api {

/// Gives the light, 0 to 1, that a value of sRGB (IEC 61966-2-1) stands for.
double to_linear(unsigned char value);

/// Gives the value of sRGB nearest to a light; of one beyond [0, 1] that of the nearer end.
std::uint8_t to_srgb(double light);

}  // namespace ccdt::api
