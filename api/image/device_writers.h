// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "api/input/colour.h"
#include "core/base/result.h"

namespace ccdt::api {

/// A picture in the colours of a device.
struct DevicePixels {
    int width = 0;
    int height = 0;
    int bits = 1;                          ///< bits of a pixel: 1, 2 or 4
    bool is_grey = false;                  ///< whether pixel values are greys in equal steps from black to white
    std::span<const Colour> colours;       ///< [at most 2^bits] colour of each pixel value
    std::span<const std::uint8_t> values;  ///< [width * height] row by row

    std::span<const std::uint8_t> row(int y) const {
        const auto columns = static_cast<std::size_t>(width);
        return values.subspan(static_cast<std::size_t>(y) * columns, columns);
    }
};

/// Options of files for devices.
struct PixelOptions {
    std::optional<double> width_mm;  ///< width of the picture; none: the file has no physical size
    bool lsb_first = false;          ///< raw only: whether the leftmost pixel of a byte is in the lowest bits
    bool inverted = false;           ///< raw only: whether all bits are inverted
};

// Writers. The same input gives the same bytes. Errors: Stopped.

/// Encodes a PNG file with `pixels.bits` bits per pixel: grey values if `pixels.is_grey`, otherwise palette indices.
Result<std::string> write_device_png(const DevicePixels& pixels, const PixelOptions& options,
                                     const std::stop_token& stop);

/// Encodes a BMP file with a palette of 1 or 4 bits per pixel, rows from bottom to top. Pixels of 2 bits are stored in
/// 4 bits, because not all readers accept 2. Source: Microsoft, BITMAPINFOHEADER.
Result<std::string> write_bmp(const DevicePixels& pixels, const PixelOptions& options, const std::stop_token& stop);

/// Writes the pixel values only, row by row from the top. Each row begins with a new byte.
Result<std::string> write_packed_rows(const DevicePixels& pixels, const PixelOptions& options,
                                      const std::stop_token& stop);

/// Writes commands for a receipt or label printer: `GS v 0` for each band of up to 256 rows. Dark pixels are printed.
/// @param pixels  a picture of two colours
/// Source: Epson, ESC/POS command reference.
Result<std::string> write_escpos(const DevicePixels& pixels, const PixelOptions& options, const std::stop_token& stop);

}  // namespace ccdt::api
