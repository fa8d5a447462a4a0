// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/crop.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <memory>

namespace ccdt {

namespace {

/// Returns the first of `length` pixels whose middle is as near as possible to a share of all pixels.
std::ptrdiff_t first_pixel(int all, int length, double share) {
    return std::clamp(static_cast<int>(std::floor(share * all - 0.5 * length)), 0, all - length);
}

/// Extracts a rectangle from planes.
class Part {
public:
    Part(int columns, int rows, int width, int height, const Focus& focus)
        : columns_(columns),
          left_(first_pixel(columns, width, focus.x)),
          top_(first_pixel(rows, height, focus.y)),
          width_(width),
          height_(height) {
        assert(width >= 1 && height >= 1 && width <= columns && height <= rows);
    }

    Plane of(const Plane& plane) const {
        if (plane.empty()) return plane;
        const std::size_t size = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
        const std::shared_ptr<float[]> pixels = std::make_shared_for_overwrite<float[]>(size);
        const std::ptrdiff_t width = width_;
        for (std::ptrdiff_t row = 0; row < height_; ++row)
            std::copy_n(plane.begin() + (top_ + row) * columns_ + left_, width, pixels.get() + row * width);
        return {pixels, size};
    }

private:
    std::ptrdiff_t columns_, left_, top_;
    int width_, height_;
};

}  // namespace

Picture part_around(const Picture& picture, int width, int height, const Focus& focus) {
    const Part part(picture.width, picture.height, width, height, focus);
    return {width, height, part.of(picture.luminance), part.of(picture.alpha)};
}

ColourPicture part_around(const ColourPicture& picture, int width, int height, const Focus& focus) {
    const Part part(picture.width, picture.height, width, height, focus);
    return {width, height, part.of(picture.red), part.of(picture.green), part.of(picture.blue), part.of(picture.alpha)};
}

}  // namespace ccdt
