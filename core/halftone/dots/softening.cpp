// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dots/softening.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/picture/pixel_ranges.h"

namespace ccdt {

void soften(Raster& raster, unsigned own, Executor& executor) {
    const unsigned sum = (own + 2) * (own + 2);
    const auto width = static_cast<std::size_t>(raster.width), height = static_cast<std::size_t>(raster.height);
    const std::vector<std::uint8_t> sharp = raster.coverage;
    for_ranges(executor, height, rows_of_task(raster.width), [&](std::size_t begin, std::size_t end) {
        std::vector<unsigned> down(width);  // weighted vertical sums of three pixels
        for (std::size_t y = begin; y < end; ++y) {
            const std::uint8_t* const row = sharp.data() + y * width;
            const std::uint8_t* const above = y > 0 ? row - width : row;
            const std::uint8_t* const below = y + 1 < height ? row + width : row;
            for (std::size_t x = 0; x < width; ++x) down[x] = above[x] + own * row[x] + below[x];
            for (std::size_t x = 0; x < width; ++x) {
                const unsigned left = down[x > 0 ? x - 1 : x], right = down[std::min(x + 1, width - 1)];
                raster.coverage[y * width + x] =
                    static_cast<std::uint8_t>((left + own * down[x] + right + sum / 2) / sum);
            }
        }
    });
}

}  // namespace ccdt
