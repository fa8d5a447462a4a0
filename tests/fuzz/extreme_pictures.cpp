// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/extreme_pictures.h"

#include <array>
#include <limits>

#include "tests/fuzz/extremes.h"

namespace ccdt::fuzz {
namespace {

constexpr float kMin = std::numeric_limits<float>::denorm_min();
constexpr float kNotOne = 1 - std::numeric_limits<float>::epsilon() / 2;
constexpr std::array<float, 16> kLight = {0,
                                          1,
                                          1,
                                          1,
                                          kNotOne,
                                          0.5F,
                                          0.003F,
                                          1e-7F,
                                          1e-38F,
                                          kMin,
                                          0.999F,
                                          0.2F,
                                          -1,
                                          2,
                                          std::numeric_limits<float>::infinity(),
                                          std::numeric_limits<float>::quiet_NaN()};

struct Size {
    int width, height;
};

constexpr std::array<Size, 8> kSizes = {{{1, 1}, {2, 1}, {1, 2}, {3, 3}, {6, 4}, {64, 1}, {1, 64}, {16, 16}}};

/// Takes a plane whose values are equal, with up to seven exceptions.
Plane take_plane(std::size_t pixels, Bytes& input) {
    const auto bits = input.take<std::uint8_t>();
    const auto values = std::make_shared<float[]>(pixels);
    std::fill_n(values.get(), pixels, kLight[bits % kLight.size()]);
    for (std::size_t i = 0; i < bits / 32U; ++i) {
        const std::size_t pixel = input.take<std::uint8_t>() % pixels;
        values[static_cast<std::ptrdiff_t>(pixel)] = take_one(kLight, input);
    }
    return {values, pixels};
}

template <class AnyPicture>
AnyPicture take_picture(Bytes& input, std::initializer_list<Plane AnyPicture::*> planes) {
    const auto bits = input.take<std::uint8_t>();
    const auto [width, height] = kSizes[bits % kSizes.size()];
    AnyPicture picture;
    picture.width = width;
    picture.height = height;
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    for (const auto plane : planes) picture.*plane = take_plane(pixels, input);
    if ((bits & 128) != 0) picture.alpha = take_plane(pixels, input);
    return picture;
}

}  // namespace

api::Decode decode_of(Bytes input) {
    return {[input](std::string_view, const api::Reading&, const std::stop_token&) mutable -> Result<Picture> {
                Bytes bytes = input;
                return take_picture<Picture>(bytes, {&Picture::luminance});
            },
            [input](std::string_view, const api::Reading&, const std::stop_token&) mutable -> Result<ColourPicture> {
                Bytes bytes = input;
                return take_picture<ColourPicture>(bytes,
                                                   {&ColourPicture::red, &ColourPicture::green, &ColourPicture::blue});
            }};
}

}  // namespace ccdt::fuzz
