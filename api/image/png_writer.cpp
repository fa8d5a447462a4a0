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
#include <vector>

#include "api/image/shades.h"

namespace ccdt::api {
namespace {

/// How pixels are stored, settled before libpng runs.
struct Layout {
    int bit_depth = 8;
    bool grey = false;
    bool transparent = false;
    std::array<png_byte, 256> stored{};  ///< by coverage: the grey value or palette index
    std::array<png_color, 256> colours{};
    std::array<png_byte, 256> alphas{};
    int palette_size = 0;              ///< of colours and alphas; 0: grey
    png_uint_32 pixels_per_metre = 0;  ///< 0: the file tells none
};

/// @param size  of the palette; its last entry is full coverage
void fill_palette(Layout& layout, const Shades& shades, std::size_t size) {
    layout.palette_size = static_cast<int>(size);
    for (std::size_t i = 0; i < size; ++i) {
        const auto& shade = shades[i * 255 / (size - 1)];
        layout.colours[i] = {shade[0], shade[1], shade[2]};
        layout.alphas[i] = shade[3];
    }
}

Layout layout_of(bool antialias, const Inks& inks) {
    const Shades shades = shades_of(inks);
    const bool black_dots = inks.foreground == kBlack && inks.background == kWhite;
    const bool white_dots = inks.foreground == kWhite && inks.background == kBlack;
    Layout layout;
    layout.transparent = inks.background.transparent;
    layout.grey = antialias ? are_grey(inks) : black_dots || white_dots;
    if (!layout.grey) fill_palette(layout, shades, antialias ? 256 : 2);
    if (!antialias) {
        layout.bit_depth = 1;
        layout.stored[black_dots ? 0 : 255] = 1;
        return layout;
    }
    for (std::size_t i = 0; i < 256; ++i) layout.stored[i] = layout.grey ? shades[i][0] : static_cast<png_byte>(i);
    return layout;
}

/// Turns one row of coverages into a row of the file.
void pack_row(const std::uint8_t* coverage, std::size_t width, const Layout& layout, png_byte* row) {
    if (layout.bit_depth == 8) {
        std::transform(coverage, coverage + width, row, [&](std::uint8_t c) { return layout.stored[c]; });
        return;
    }
    for (std::size_t x = 0; x < width; x += 8) {
        unsigned bits = 0;
        for (std::size_t i = 0; i < 8; ++i) bits = bits << 1 | (x + i < width ? layout.stored[coverage[x + i]] : 0U);
        *row++ = static_cast<png_byte>(bits);
    }
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

void write_header(png_structp png, png_infop info, const Raster& raster, const Layout& layout) {
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    // Runs are nearly all there is to find in discs: searching for more costs 2 to 40 times the time and saves at
    // most a tenth, most often nothing.
    png_set_compression_level(png, 1);
    png_set_compression_strategy(png, Z_RLE);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
    png_set_IHDR(png, info, static_cast<png_uint_32>(raster.width), static_cast<png_uint_32>(raster.height),
                 layout.bit_depth, layout.grey ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_PALETTE, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (!layout.grey) png_set_PLTE(png, info, layout.colours.data(), layout.palette_size);
    if (!layout.grey && layout.transparent) {
        png_set_tRNS(png, info, layout.alphas.data(), layout.palette_size, nullptr);
    }
    const png_uint_32 density = layout.pixels_per_metre;
    if (density > 0) png_set_pHYs(png, info, density, density, PNG_RESOLUTION_METER);
    png_write_info(png, info);
}

/// libpng reports errors by a jump back into this function, so it owns nothing that would need destroying.
/// @param row  room for one row of the file
/// @returns    false on an error
bool write_all(png_structp png, png_infop info, const Raster& raster, const Layout& layout, png_byte* row) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    write_header(png, info, raster, layout);
    const auto width = static_cast<std::size_t>(raster.width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(raster.height); ++y) {
        pack_row(raster.coverage.data() + y * width, width, layout, row);
        png_write_row(png, row);
    }
    png_write_end(png, info);
    return true;
}

}  // namespace

Result<std::string> write_png(const Raster& raster, bool antialias, const Inks& inks, std::optional<double> width_mm) {
    Layout layout = layout_of(antialias, inks);
    if (width_mm) {
        const double density = std::round(1000 * raster.width / *width_mm);
        layout.pixels_per_metre = static_cast<png_uint_32>(std::clamp(density, 1.0, double{PNG_UINT_31_MAX}));
    }
    std::vector<png_byte> row(static_cast<std::size_t>(raster.width));
    Sink sink;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
    png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
    if (info != nullptr) png_set_write_fn(png, &sink, append, nullptr);
    const bool written = info != nullptr && write_all(png, info, raster, layout, row.data());
    png_destroy_write_struct(&png, &info);
    if (!written) return failure(ErrorCode::Internal, "the picture could not be encoded");
    return std::move(sink.bytes);
}

}  // namespace ccdt::api
