// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace ccdt {

/// Rounds each coverage to 0 or 255 by error diffusion. The rounding error is passed on to neighbouring pixels that are
/// rounded later, so that local sums stay nearly the same.
///
/// @param shares  [width * height] coverage of each pixel; 255 means fully covered; modified
/// Source: Floyd, Steinberg 1976, An adaptive algorithm for spatial greyscale. The direction alternates between rows.
/// Departures: pixels of 0 and 255 do not change and receive no error. If no neighbour can receive an error, it is
/// added to the next pixel that can change.
void diffuse(std::vector<std::uint8_t>& shares, int width, int height);

}  // namespace ccdt
