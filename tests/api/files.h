// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ccdt::api {

/// The bytes of a file beside these tests, or among the pictures that all tests share.
std::string fixture(const std::string& name);
std::string photograph(const std::string& name);
std::string polygon_file(const std::string& name);

/// As bytes travel inside JSON.
std::string base64(std::string_view bytes);

/// A PNG as libpng decodes it.
struct DecodedPng {
    int width = 0;
    int height = 0;
    int bit_depth = 0;                                ///< in the file
    int colour_type = 0;                              ///< in the file, as PNG_COLOR_TYPE_...
    std::vector<std::array<std::uint8_t, 4>> pixels;  ///< red, green, blue, alpha

    std::array<std::uint8_t, 4> at(int x, int y) const {
        return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

DecodedPng decode_png(std::string_view file);

}  // namespace ccdt::api
