#pragma once

#include <vector>

namespace ccdt {

/// Blurs a plane of values by about a Gaussian, as if mirrored at its sides.
///
/// @param values  [width * height], finite
/// @param sigma   pixels, >= 0; more than half a side count as that
/// By two extended boxes each way, whose standard deviation is exact. O(pixels), whatever the sigma.
/// Source: Gwosdek, Grewenig, Bruhn, Weickert 2011, Theoretical foundations of Gaussian convolution by extended box
/// filtering, section 3.
std::vector<float> blurred(const std::vector<float>& values, int width, int height, double sigma);

}  // namespace ccdt
