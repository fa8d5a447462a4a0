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

namespace ccdt::api {
namespace {

/// What each coverage looks like: colours and alphas of a palette, the first `size` in use.
struct Palette {
    std::array<png_color, 256> colours{};
    std::array<png_byte, 256> alphas{};
    int size = 0;
    bool transparent = false;
};

/// How pixels are stored, settled before libpng runs.
struct Layout {
    int bit_depth = 8;
    bool grey = false;
    std::array<png_byte, 256> stored{};  ///< by coverage: the grey value or palette index
    Palette palette;                     ///< unless grey
    png_uint_32 pixels_per_metre = 0;    ///< 0: the file tells none
};

double to_linear(unsigned char value) {
    const double share = value / 255.0;
    return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
}

png_byte to_srgb(double linear) {
    const double share = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    return static_cast<png_byte>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

png_byte mix(unsigned char background, unsigned char foreground, double coverage) {
    return to_srgb((1 - coverage) * to_linear(background) + coverage * to_linear(foreground));
}

png_color mix(const Inks& inks, double coverage) {
    const Colour& over = inks.foreground;
    const Colour& under = inks.background.transparent ? inks.foreground : inks.background;
    return {mix(under.red, over.red, coverage), mix(under.green, over.green, coverage),
            mix(under.blue, over.blue, coverage)};
}

/// @param size  of the palette; its last entry is full coverage
Palette palette_of(const Inks& inks, int size) {
    Palette palette;
    palette.size = size;
    palette.transparent = inks.background.transparent;
    for (int i = 0; i < size; ++i) {
        const double coverage = static_cast<double>(i) / (size - 1);
        palette.colours[static_cast<std::size_t>(i)] = mix(inks, coverage);
        palette.alphas[static_cast<std::size_t>(i)] = static_cast<png_byte>(std::lround(255 * coverage));
    }
    return palette;
}

bool is_grey(const Colour& colour) {
    return !colour.transparent && colour.red == colour.green && colour.green == colour.blue;
}

Layout layout_of(bool antialias, const Inks& inks) {
    Layout layout;
    if (antialias) {
        layout.palette = palette_of(inks, 256);
        layout.grey = is_grey(inks.foreground) && is_grey(inks.background);
        for (std::size_t i = 0; i < 256; ++i) {
            layout.stored[i] = layout.grey ? layout.palette.colours[i].red : static_cast<png_byte>(i);
        }
        return layout;
    }
    const bool black_dots = inks.foreground == kBlack && inks.background == kWhite;
    const bool white_dots = inks.foreground == kWhite && inks.background == kBlack;
    layout.bit_depth = 1;
    layout.grey = black_dots || white_dots;
    layout.palette = palette_of(inks, 2);
    layout.stored[black_dots ? 0 : 255] = 1;
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
    const Palette& palette = layout.palette;
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    // Runs are nearly all there is to find in discs: searching for more costs 2 to 40 times the time and saves at
    // most a tenth, most often nothing.
    png_set_compression_level(png, 1);
    png_set_compression_strategy(png, Z_RLE);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
    png_set_IHDR(png, info, static_cast<png_uint_32>(raster.width), static_cast<png_uint_32>(raster.height),
                 layout.bit_depth, layout.grey ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_PALETTE, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (!layout.grey) png_set_PLTE(png, info, palette.colours.data(), palette.size);
    if (!layout.grey && palette.transparent) png_set_tRNS(png, info, palette.alphas.data(), palette.size, nullptr);
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
