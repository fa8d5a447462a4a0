// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/api/files.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cstring>
#include <fstream>
#include <iterator>

namespace ccdt::api {
namespace {

std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    EXPECT_TRUE(file) << path;
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string fixture(const std::string& name) {
    return read_file(std::string(CCDT_API_TEST_DATA) + "/" + name);
}

std::string photograph(const std::string& name) {
    return read_file(std::string(CCDT_TEST_DATA) + "/images/" + name);
}

std::string polygon_file(const std::string& name) {
    return read_file(std::string(CCDT_TEST_DATA) + "/polygons/" + name);
}

std::string base64(std::string_view bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned bits = 0;
        for (std::size_t k = i; k < i + 3; ++k) {
            bits = bits << 8 | (k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0U);
        }
        for (int shift = 18; shift >= 0; shift -= 6) text += digits[bits >> shift & 63];
    }
    for (std::size_t pad = 0; pad < (3 - bytes.size() % 3) % 3; ++pad) text[text.size() - 1 - pad] = '=';
    return text;
}

DecodedPng decode_png(std::string_view file) {
    DecodedPng result;
    EXPECT_GT(file.size(), 33U);
    if (file.size() <= 33) return result;
    result.bit_depth = static_cast<unsigned char>(file[24]);  // PNG, section 11.2.2: IHDR is always the first chunk
    result.colour_type = static_cast<unsigned char>(file[25]);
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    EXPECT_TRUE(png_image_begin_read_from_memory(&image, file.data(), file.size())) << image.message;
    image.format = PNG_FORMAT_RGBA;
    result.width = static_cast<int>(image.width);
    result.height = static_cast<int>(image.height);
    result.pixels.resize(std::size_t{image.width} * image.height);
    EXPECT_TRUE(png_image_finish_read(&image, nullptr, result.pixels.data(), 0, nullptr)) << image.message;
    return result;
}

}  // namespace ccdt::api
