// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/dither/device_colours.h"

namespace ccdt {

/// Marks a pixel whose colour is not given.
inline constexpr std::uint8_t kAnyColour = 255;

/// Visits the pixels row by row, and passes the error of each one on to neighbours that are visited later.
///
/// @tparam Value  array of numbers
/// @param given   [width * height] number of a colour that the pixel must have, or kAnyColour; given pixels neither
///                receive an error nor pass one on
/// @param wanted  Value(std::size_t pixel)
/// @param choose  Value(std::size_t pixel, const Value& value): chooses the colour of a pixel that should show a value,
///                its wanted one plus the errors passed on to it; returns what the pixel shows
///
/// Source: Floyd, Steinberg 1976, An adaptive algorithm for spatial greyscale. The direction alternates between rows.
template <class Value, class Wanted, class Choose>
void diffuse(std::span<const std::uint8_t> given, int width, int height, const Wanted& wanted, const Choose& choose) {
    const auto add = [](Value& sum, const Value& error, float weight) {
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += weight * error[c];
    };
    const auto columns = static_cast<std::size_t>(width);
    // Errors passed on to this row and to the next one, with a margin of one pixel on both sides.
    std::vector<Value> here(columns + 2, Value{}), below(columns + 2, Value{});
    for (int y = 0; y < height; ++y) {
        const bool is_forward = y % 2 == 0;
        Value carried{};
        for (std::size_t step = 0; step < columns; ++step) {
            const std::size_t x = is_forward ? step : columns - 1 - step;
            const std::size_t pixel = static_cast<std::size_t>(y) * columns + x;
            if (given[pixel] != kAnyColour) {
                carried = {};
                continue;
            }
            Value error = wanted(pixel);
            add(error, here[x + 1], 1);
            add(error, carried, 1);
            add(error, choose(pixel, error), -1);
            carried = {};
            add(carried, error, 7.0f / 16);
            add(below[is_forward ? x : x + 2], error, 3.0f / 16);
            add(below[x + 1], error, 5.0f / 16);
            add(below[is_forward ? x + 2 : x], error, 1.0f / 16);
        }
        here.swap(below);
        std::ranges::fill(below, Value{});
    }
}

/// Chooses a colour of the device for each pixel by error diffusion, so that local means stay nearly the same.
///
/// @param wanted  [width * height] wanted colours in the opponent space, within the device's gamut
/// @param given   [width * height] number of a colour that the pixel must have, or kAnyColour
/// @returns       [width * height] numbers of colours
///
/// Deterministic. O(pixels * colours).
std::vector<std::uint8_t> diffuse_error(std::span<const DeviceColours::Opponent> wanted,
                                        std::span<const std::uint8_t> given, int width, int height,
                                        const DeviceColours& device);

}  // namespace ccdt
