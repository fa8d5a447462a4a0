// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/error_diffusion.h"

#include <algorithm>
#include <cstddef>

namespace ccdt {

namespace {

using Opponent = DeviceColours::Opponent;

void add(Opponent& sum, const Opponent& error, float weight) {
    for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += weight * error[c];
}

}  // namespace

std::vector<std::uint8_t> diffuse_error(std::span<const Opponent> wanted, std::span<const std::uint8_t> given,
                                        int width, int height, const DeviceColours& device) {
    const auto columns = static_cast<std::size_t>(width);
    std::vector<std::uint8_t> chosen(wanted.size());
    // Errors passed on to this row and to the next one, with a margin of one pixel on both sides.
    std::vector<Opponent> here(columns + 2, Opponent{}), below(columns + 2, Opponent{});
    for (int y = 0; y < height; ++y) {
        const bool is_forward = y % 2 == 0;
        Opponent carried{};
        for (std::size_t step = 0; step < columns; ++step) {
            const std::size_t x = is_forward ? step : columns - 1 - step;
            const std::size_t pixel = static_cast<std::size_t>(y) * columns + x;
            if (given[pixel] != kAnyColour) {
                chosen[pixel] = given[pixel];
                carried = {};
                continue;
            }
            Opponent error = wanted[pixel];
            add(error, here[x + 1], 1);
            add(error, carried, 1);
            chosen[pixel] = static_cast<std::uint8_t>(device.nearest(error));
            add(error, device[chosen[pixel]], -1);
            carried = {};
            add(carried, error, 7.0f / 16);
            add(below[is_forward ? x : x + 2], error, 3.0f / 16);
            add(below[x + 1], error, 5.0f / 16);
            add(below[is_forward ? x + 2 : x], error, 1.0f / 16);
        }
        here.swap(below);
        std::ranges::fill(below, Opponent{});
    }
    return chosen;
}

}  // namespace ccdt
