// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace ccdt {

/// Turns shares of pixels, 255 being all of one, into 0 and 255, and hands what each gets too much or too little on to
/// pixels that come after it: the sum stays, also locally. Pixels that are empty or full stay so.
///
/// Departs from its source in that, and in that errors which no neighbour can take wait for the next pixel that can.
/// Source: Floyd, Steinberg 1976, An adaptive algorithm for spatial greyscale; rows in turn from either side.
void diffuse(std::vector<std::uint8_t>& shares, int width, int height);

}  // namespace ccdt
