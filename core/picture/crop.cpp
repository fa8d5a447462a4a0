// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/picture/crop.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <memory>

namespace ccdt {

namespace {

/// Extracts a centred rectangle from planes.
class Middle {
public:
    Middle(int columns, int rows, int width, int height)
        : columns_(columns), left_((columns - width) / 2), top_((rows - height) / 2), width_(width), height_(height) {
        assert(width >= 1 && height >= 1 && width <= columns && height <= rows);
    }

    Plane of(const Plane& plane) const {
        if (plane.empty()) return plane;
        const std::size_t size = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
        const std::shared_ptr<float[]> part = std::make_shared_for_overwrite<float[]>(size);
        const std::ptrdiff_t width = width_;
        for (std::ptrdiff_t row = 0; row < height_; ++row)
            std::copy_n(plane.begin() + (top_ + row) * columns_ + left_, width, part.get() + row * width);
        return {part, size};
    }

private:
    std::ptrdiff_t columns_, left_, top_;
    int width_, height_;
};

}  // namespace

Picture middle_of(const Picture& picture, int width, int height) {
    const Middle middle(picture.width, picture.height, width, height);
    return {width, height, middle.of(picture.luminance), middle.of(picture.alpha)};
}

ColourPicture middle_of(const ColourPicture& picture, int width, int height) {
    const Middle middle(picture.width, picture.height, width, height);
    return {width,
            height,
            middle.of(picture.red),
            middle.of(picture.green),
            middle.of(picture.blue),
            middle.of(picture.alpha)};
}

}  // namespace ccdt
