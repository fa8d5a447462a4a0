// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ccdt::api {

/// Returns the content of a file in tests/api/data.
std::string fixture(const std::string& name);

/// Returns the content of a picture or polygon that all tests share.
std::string photograph(const std::string& name);
std::string polygon_file(const std::string& name);

/// Encodes bytes in base64.
std::string base64(std::string_view bytes);

/// A PNG decoded by libpng.
struct DecodedPng {
    int width = 0;
    int height = 0;
    int bit_depth = 0;                                ///< bit depth of the file
    int colour_type = 0;                              ///< colour type of the file, PNG_COLOR_TYPE_...
    std::vector<std::array<std::uint8_t, 4>> pixels;  ///< red, green, blue, alpha

    std::array<std::uint8_t, 4> at(int x, int y) const {
        return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

DecodedPng decode_png(std::string_view file);

}  // namespace ccdt::api
