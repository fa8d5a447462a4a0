// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/png_writer.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <numeric>
#include <vector>

#include "api/image/shades.h"

namespace ccdt::api {
namespace {

/// Layout of stored pixels, determined before libpng runs.
struct Layout {
    int bit_depth = 8;
    int colour_type = PNG_COLOR_TYPE_GRAY;
    bool transparent = false;
    bool is_srgb = false;                ///< whether values are sRGB; if not, the file states no colour space
    std::array<png_byte, 256> stored{};  ///< grey value or palette index for each value of the picture
    std::array<png_color, 256> colours{};
    std::array<png_byte, 256> alphas{};
    int palette_size = 0;              ///< number of used elements of `colours` and `alphas`
    png_uint_32 pixels_per_metre = 0;  ///< 0: not in the file
};

void add_to_palette(Layout& layout, const std::array<std::uint8_t, 4>& shade) {
    const auto i = static_cast<std::size_t>(layout.palette_size++);
    layout.colours[i] = {shade[0], shade[1], shade[2]};
    layout.alphas[i] = shade[3];
}

png_uint_32 pixels_per_metre(int width, std::optional<double> width_mm) {
    if (!width_mm) return 0;
    const double density = std::round(1000 * width / *width_mm);
    return static_cast<png_uint_32>(std::clamp(density, 1.0, double{PNG_UINT_31_MAX}));
}

Layout layout_of(const DotImage& image, std::optional<double> width_mm) {
    Layout layout;
    layout.transparent = image.transparent;
    layout.is_srgb = true;
    layout.pixels_per_metre = pixels_per_metre(image.width, width_mm);
    const bool grey = image.is_bilevel() || (image.grey && image.colours > 2);
    layout.colour_type = grey                ? PNG_COLOR_TYPE_GRAY
                         : image.colours > 0 ? PNG_COLOR_TYPE_PALETTE
                         : image.transparent ? PNG_COLOR_TYPE_RGB_ALPHA
                                             : PNG_COLOR_TYPE_RGB;
    std::iota(layout.stored.begin(), layout.stored.end(), png_byte{0});
    if (image.colours == 0) return layout;
    layout.bit_depth = image.colours > 16 ? 8 : image.colours > 4 ? 4 : image.colours > 2 ? 2 : 1;
    for (std::size_t i = 0; i < image.colours; ++i) {
        if (grey) {
            layout.stored[i] = static_cast<png_byte>(image.palette[i][0] >> (8 - layout.bit_depth));
        } else {
            add_to_palette(layout, image.palette[i]);
        }
    }
    return layout;
}

struct Sink {
    std::string bytes;
    bool failed = false;
};

void append(png_structp png, png_bytep data, std::size_t size) {
    auto* const sink = static_cast<Sink*>(png_get_io_ptr(png));
    try {
        sink->bytes.append(reinterpret_cast<const char*>(data), size);
    } catch (const std::exception&) {
        sink->failed = true;
    }
    if (sink->failed) png_error(png, "out of memory");
}

[[noreturn]] void on_error(png_structp png, png_const_charp) {
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void write_header(png_structp png, png_infop info, const DotImage& image, const Layout& layout) {
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    // Pictures of discs have hardly any redundancy other than runs. A search for other matches takes 2 to 40 times as
    // long. It saves at most a tenth of the file size, usually nothing.
    png_set_compression_level(png, 1);
    png_set_compression_strategy(png, Z_RLE);
    // Pictures with several channels have runs only after each pixel has been subtracted from the next pixel.
    png_set_filter(png, PNG_FILTER_TYPE_BASE, image.channels() > 1 ? PNG_FILTER_SUB : PNG_FILTER_NONE);
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height),
                 layout.bit_depth, layout.colour_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (layout.palette_size > 0) png_set_PLTE(png, info, layout.colours.data(), layout.palette_size);
    if (layout.palette_size > 0 && layout.transparent) {
        png_set_tRNS(png, info, layout.alphas.data(), layout.palette_size, nullptr);
    }
    if (layout.is_srgb) png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_RELATIVE);
    const png_uint_32 density = layout.pixels_per_metre;
    if (density > 0) png_set_pHYs(png, info, density, density, PNG_RESOLUTION_METER);
    png_write_info(png, info);
    png_set_packing(png);  // rows have at least a byte per value
}

/// Writes the file. libpng reports errors by longjmp() into this function, so the function must not have local objects
/// with destructors.
/// @param row      buffer for one row
/// @param set_row  fills the buffer, as set_row(y, row); must not throw
/// @returns        false on an error or a stop
template <class SetRow>
bool write_all(png_structp png, png_infop info, const DotImage& image, const Layout& layout, png_byte* row,
               const SetRow& set_row, const std::stop_token& stop) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    write_header(png, info, image, layout);
    for (int y = 0; y < image.height; ++y) {
        if (stop.stop_requested()) return false;
        set_row(y, row);
        png_write_row(png, row);
    }
    png_write_end(png, info);
    return true;
}

/// @param image     only its size and number of channels are used
/// @param row_size  maximum number of bytes in a row
template <class SetRow>
Result<std::string> write_file(const DotImage& image, const Layout& layout, std::size_t row_size, const SetRow& set_row,
                               const std::stop_token& stop) {
    std::vector<png_byte> row(row_size);
    Sink sink;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
    png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
    if (info != nullptr) png_set_write_fn(png, &sink, append, nullptr);
    const bool written = info != nullptr && write_all(png, info, image, layout, row.data(), set_row, stop);
    png_destroy_write_struct(&png, &info);
    if (written) return std::move(sink.bytes);
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped while the picture was encoded");
    return failure(ErrorCode::Internal, "the picture could not be encoded");
}

}  // namespace

Result<std::string> write_png(const DotImage& image, std::optional<double> width_mm, const std::stop_token& stop) {
    const Layout layout = layout_of(image, width_mm);
    const auto set_row = [&](int y, png_byte* row) {
        std::transform(image.row(y), image.row(y) + image.row_size(), row,
                       [&](std::uint8_t value) { return layout.stored[value]; });
    };
    return write_file(image, layout, image.row_size(), set_row, stop);
}

Result<std::string> write_greys(std::span<const std::uint16_t> greys, int width, int height, int bits,
                                const std::stop_token& stop) {
    DotImage image;
    image.width = width;
    image.height = height;
    image.colours = 1;  // makes channels() return 1
    Layout layout;
    layout.bit_depth = bits;
    const auto columns = static_cast<std::size_t>(width);
    const auto set_row = [&](int y, png_byte* row) {
        for (const std::uint16_t grey : greys.subspan(static_cast<std::size_t>(y) * columns, columns)) {
            if (bits > 8) *row++ = static_cast<png_byte>(grey >> 8);
            *row++ = static_cast<png_byte>(grey & 255);
        }
    };
    return write_file(image, layout, 2 * columns, set_row, stop);
}

}  // namespace ccdt::api
