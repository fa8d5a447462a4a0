// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/device_writers.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "api/image/png_writer.h"
#include "core/picture/srgb.h"

namespace ccdt::api {
namespace {

/// Appends the lowest `size` bytes of a value, the lowest byte first.
void append(std::string& bytes, std::size_t value, int size) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xff));
}

/// Appends a row of pixels, packed into bytes. The leftmost pixel is in the highest bits.
void append_packed(std::string& bytes, std::span<const std::uint8_t> row, int bits) {
    const auto per_byte = static_cast<std::size_t>(8 / bits);
    for (std::size_t x = 0; x < row.size(); x += per_byte) {
        unsigned byte = 0;
        for (std::size_t i = 0; i < per_byte; ++i) byte = byte << bits | (x + i < row.size() ? row[x + i] : 0U);
        bytes.push_back(static_cast<char>(byte));
    }
}

/// Reverses the order of the pixels in a byte.
char reversed(char byte, int bits) {
    const auto from = static_cast<unsigned char>(byte);
    const unsigned mask = (1U << bits) - 1;
    unsigned to = 0;
    for (int shift = 0; shift < 8; shift += bits) to = to << bits | (from >> shift & mask);
    return static_cast<char>(to);
}

/// Calls write(row) for each row in [begin, end). Errors: Stopped.
template <class Write>
Result<void> for_rows(const DevicePixels& pixels, int begin, int end, const std::stop_token& stop, const Write& write) {
    for (int y = begin; y < end; ++y) {
        if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped while a picture was written");
        write(pixels.row(y));
    }
    return {};
}

double luminance_of(const Colour& colour) {
    const auto light = [](unsigned char value) { return light_of_srgb(value / 255.0); };
    return ccdt::luminance_of(light(colour.red), light(colour.green), light(colour.blue));
}

}  // namespace

Result<std::string> write_device_png(const DevicePixels& pixels, const PixelOptions& options,
                                     const std::stop_token& stop) {
    DotImage image;
    image.width = pixels.width;
    image.height = pixels.height;
    image.grey = pixels.is_grey;
    image.colours = pixels.colours.size();
    for (std::size_t i = 0; i < pixels.colours.size(); ++i)
        image.palette[i] = {pixels.colours[i].red, pixels.colours[i].green, pixels.colours[i].blue, 255};
    image.pixels.assign(pixels.values.begin(), pixels.values.end());
    return write_png(image, options.width_mm, stop);
}

Result<std::string> write_bmp(const DevicePixels& pixels, const PixelOptions& options, const std::stop_token& stop) {
    constexpr std::size_t kFileHeader = 14, kInfoHeader = 40, kColour = 4, kRowAlignment = 4;
    const int bits = pixels.bits == 1 ? 1 : 4;
    const auto columns = static_cast<std::size_t>(pixels.width), rows = static_cast<std::size_t>(pixels.height);
    const std::size_t row_size = (columns * static_cast<std::size_t>(bits) + 31) / 32 * kRowAlignment;
    const std::size_t offset = kFileHeader + kInfoHeader + kColour * pixels.colours.size();
    const double density = options.width_mm ? std::round(1000 * pixels.width / *options.width_mm) : 0;
    const auto pixels_per_metre = static_cast<std::size_t>(std::clamp(density, 0.0, 2147483647.0));

    std::string bytes = "BM";
    bytes.reserve(offset + row_size * rows);
    append(bytes, offset + row_size * rows, 4);
    append(bytes, 0, 4);
    append(bytes, offset, 4);
    append(bytes, kInfoHeader, 4);
    append(bytes, columns, 4);
    append(bytes, rows, 4);
    append(bytes, 1, 2);  // planes
    append(bytes, static_cast<std::size_t>(bits), 2);
    append(bytes, 0, 4);  // no compression
    append(bytes, row_size * rows, 4);
    append(bytes, pixels_per_metre, 4);
    append(bytes, pixels_per_metre, 4);
    append(bytes, pixels.colours.size(), 4);
    append(bytes, pixels.colours.size(), 4);
    for (const Colour& colour : pixels.colours) {
        for (const unsigned char value : {colour.blue, colour.green, colour.red}) append(bytes, value, 1);
        append(bytes, 0, 1);
    }
    for (int y = pixels.height - 1; y >= 0; --y) {
        const auto written = for_rows(pixels, y, y + 1, stop, [&](std::span<const std::uint8_t> row) {
            const std::size_t end = bytes.size() + row_size;
            append_packed(bytes, row, bits);
            bytes.resize(end, '\0');
        });
        if (!written) return tl::unexpected(written.error());
    }
    return bytes;
}

Result<std::string> write_packed_rows(const DevicePixels& pixels, const PixelOptions& options,
                                      const std::stop_token& stop) {
    std::string bytes;
    const auto written = for_rows(pixels, 0, pixels.height, stop,
                                  [&](std::span<const std::uint8_t> row) { append_packed(bytes, row, pixels.bits); });
    if (!written) return tl::unexpected(written.error());
    for (char& byte : bytes) {
        if (options.lsb_first) byte = reversed(byte, pixels.bits);
        if (options.inverted) byte = static_cast<char>(~byte);
    }
    return bytes;
}

Result<std::string> write_escpos(const DevicePixels& pixels, const PixelOptions&, const std::stop_token& stop) {
    constexpr int kBand = 255;  // rows; buffers are small, and some printers read only the low byte of the number
    assert(pixels.colours.size() == 2);
    const bool is_first_dark = luminance_of(pixels.colours[0]) < luminance_of(pixels.colours[1]);
    const auto row_size = static_cast<std::size_t>((pixels.width + 7) / 8);
    std::string bytes = "\x1b@";  // initialises the printer
    std::vector<std::uint8_t> dark(static_cast<std::size_t>(pixels.width));
    for (int top = 0; top < pixels.height; top += kBand) {
        const int bottom = std::min(top + kBand, pixels.height);
        bytes += std::string("\x1dv0\0", 4);
        append(bytes, row_size, 2);
        append(bytes, static_cast<std::size_t>(bottom - top), 2);
        const auto written = for_rows(pixels, top, bottom, stop, [&](std::span<const std::uint8_t> row) {
            std::ranges::transform(row, dark.begin(), [&](std::uint8_t value) {
                return static_cast<std::uint8_t>((value == 0) == is_first_dark);
            });
            append_packed(bytes, dark, 1);
        });
        if (!written) return tl::unexpected(written.error());
    }
    return bytes;
}

}  // namespace ccdt::api
