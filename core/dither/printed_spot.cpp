// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/printed_spot.h"

#include <cassert>

namespace ccdt {

PrintedSpot::PrintedSpot(double diameter) {
    assert(diameter >= kMinSpot && diameter <= kMaxSpot);
    // The square of a pixel has 256 x 256 samples. `counts` holds the number of samples that each set of discs covers,
    // and no other disc.
    constexpr int kSamples = 256;
    std::array<int, kOutside> counts{};
    for (int row = 0; row < kSamples; ++row) {
        for (int column = 0; column < kSamples; ++column) {
            const double x = (column + 0.5) / kSamples - 0.5, y = (row + 0.5) / kSamples - 0.5;
            unsigned discs = 0;
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    if ((x - dx) * (x - dx) + (y - dy) * (y - dy) <= diameter * diameter / 4) discs |= bit(dx, dy);
                }
            }
            ++counts[discs];
        }
    }
    for (unsigned dark = 0; dark < kOutside; ++dark) {
        int covered = 0;
        for (unsigned discs = 0; discs < kOutside; ++discs) {
            if ((discs & dark) != 0) covered += counts[discs];
        }
        shares_[dark] = static_cast<float>(covered) / (kSamples * kSamples);
    }
}

}  // namespace ccdt
