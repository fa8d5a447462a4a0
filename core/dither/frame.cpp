// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/frame.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/picture/bilinear.h"
#include "core/picture/pixel_ranges.h"
#include "core/picture/reduction.h"
#include "core/picture/tone.h"

namespace ccdt {

namespace {

std::size_t area(const FrameSize& size) {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

Plane turned(const Plane& plane, int width, int height, int quarters) {
    if (plane.empty()) return {};
    const auto columns = static_cast<std::ptrdiff_t>(width), rows = static_cast<std::ptrdiff_t>(height);
    const std::shared_ptr<float[]> values(new float[plane.size()]);
    for (std::ptrdiff_t y = 0; y < rows; ++y) {
        for (std::ptrdiff_t x = 0; x < columns; ++x) {
            const std::ptrdiff_t to = quarters == 1   ? x * rows + (rows - 1 - y)
                                      : quarters == 2 ? (rows - 1 - y) * columns + (columns - 1 - x)
                                                      : (columns - 1 - x) * rows + y;
            values[to] = plane[static_cast<std::size_t>(y * columns + x)];
        }
    }
    return {values, plane.size()};
}

/// Returns the light of a picture on a background.
LightPlanes on_background(const ColourPicture& picture, const Light& background, Executor& executor) {
    const std::array<const Plane*, 3> planes = {&picture.red, &picture.green, &picture.blue};
    const std::array<float, 3> behind = {background.red, background.green, background.blue};
    LightPlanes light;
    for (std::size_t c = 0; c < planes.size(); ++c) {
        light[c].resize(planes[c]->size());
        for_pixels(executor, light[c].size(), [&](std::size_t i) {
            const float own = to_share((*planes[c])[i]);
            light[c][i] = picture.alpha.empty() ? own : mix(behind[c], own, to_share(picture.alpha[i]));
        });
    }
    return light;
}

/// Enlarges one channel bilinearly.
std::vector<float> enlarged(const std::vector<float>& values, const FrameSize& from, const FrameSize& to,
                            Executor& executor) {
    std::vector<float> result(area(to));
    const auto columns = static_cast<std::size_t>(to.width);
    for_rows(executor, to.width, static_cast<std::size_t>(to.height), [&](std::size_t y) {
        for (std::size_t x = 0; x < columns; ++x) {
            const Point position{(static_cast<double>(x) + 0.5) * from.width / to.width,
                                 (static_cast<double>(y) + 0.5) * from.height / to.height};
            result[y * columns + x] = interpolated(values, from.width, from.height, position);
        }
    });
    return result;
}

}  // namespace

ColourPicture turned(const ColourPicture& picture, int quarters) {
    assert(quarters >= 0 && quarters < 4);
    if (quarters == 0) return picture;
    const auto turn = [&](const Plane& plane) { return turned(plane, picture.width, picture.height, quarters); };
    const bool swaps = quarters % 2 == 1;
    return {swaps ? picture.height : picture.width,
            swaps ? picture.width : picture.height,
            turn(picture.red),
            turn(picture.green),
            turn(picture.blue),
            turn(picture.alpha)};
}

LightPlanes framed(const ColourPicture& picture, const FrameSize& inner, const FrameSize& frame,
                   const Light& background, Executor& executor) {
    assert(inner.width <= frame.width && inner.height <= frame.height);
    const CellGrid cells{std::min(inner.width, picture.width), std::min(inner.height, picture.height)};
    const FrameSize small{cells.columns, cells.rows};
    LightPlanes light = small == FrameSize{picture.width, picture.height}
                            ? on_background(picture, background, executor)
                            : on_background(reduced(picture, cells, executor), background, executor);
    const std::array<float, 3> around = {background.red, background.green, background.blue};
    for (std::size_t c = 0; c < light.size(); ++c) {
        if (small != inner) light[c] = enlarged(light[c], small, inner, executor);
        if (inner == frame) continue;
        std::vector<float> result(area(frame), around[c]);
        const auto left = static_cast<std::size_t>((frame.width - inner.width) / 2);
        const auto top = static_cast<std::size_t>((frame.height - inner.height) / 2);
        const auto columns = static_cast<std::size_t>(inner.width), across = static_cast<std::size_t>(frame.width);
        for (std::size_t y = 0; y < static_cast<std::size_t>(inner.height); ++y)
            std::copy_n(&light[c][y * columns], columns, &result[(top + y) * across + left]);
        light[c] = std::move(result);
    }
    return light;
}

}  // namespace ccdt
