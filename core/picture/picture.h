// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <utility>

namespace ccdt {

/// An immutable image with one value per pixel, row by row from the top. Copies share memory.
class Plane {
public:
    Plane() = default;
    Plane(std::shared_ptr<const float[]> values, std::size_t size) : values_(std::move(values)), size_(size) {}
    Plane(std::initializer_list<float> values) : size_(values.size()) {
        const auto copy = std::make_shared<float[]>(size_);
        std::ranges::copy(values, copy.get());
        values_ = copy;
    }

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    float operator[](std::size_t pixel) const { return values_[static_cast<std::ptrdiff_t>(pixel)]; }
    const float* begin() const { return values_.get(); }
    const float* end() const { return values_.get() + size_; }

    friend bool operator==(const Plane& a, const Plane& b) { return std::ranges::equal(a, b); }

private:
    std::shared_ptr<const float[]> values_;
    std::size_t size_ = 0;
};

/// Way in which the partly transparent pixels of a picture are mixed with the ground behind them.
enum class AlphaMixing {
    Display,  ///< mixes sRGB values, as viewers and editors do
    Linear,   ///< mixes linear light
};

/// A grey picture in linear light.
struct Picture {
    int width = 0;
    int height = 0;
    Plane luminance;  ///< [width * height], relative luminance in [0, 1], not premultiplied
    Plane alpha;      ///< [width * height] in [0, 1]; empty: opaque
};

/// A picture in linear light, with the primaries of sRGB.
struct ColourPicture {
    int width = 0;
    int height = 0;
    Plane red, green, blue;  ///< [width * height] each, in [0, 1], not premultiplied
    Plane alpha;             ///< [width * height] in [0, 1]; empty: opaque
};

}  // namespace ccdt
