// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/tiff_writer.h"

#include <tiffio.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <vector>

#include "api/image/shades.h"

namespace ccdt::api {
namespace {

constexpr double kMillimetresPerInch = 25.4;

struct MemoryFile {
    std::string bytes;
    std::size_t position = 0;
};

MemoryFile& file_of(thandle_t handle) {
    return *static_cast<MemoryFile*>(handle);
}

tmsize_t read(thandle_t handle, void* target, tmsize_t size) {
    MemoryFile& file = file_of(handle);
    const std::size_t rest = file.bytes.size() - std::min(file.position, file.bytes.size());
    const std::size_t count = std::min(rest, static_cast<std::size_t>(size));
    std::memcpy(target, file.bytes.data() + file.bytes.size() - rest, count);
    file.position += count;
    return static_cast<tmsize_t>(count);
}

tmsize_t write(thandle_t handle, void* source, tmsize_t size) {
    MemoryFile& file = file_of(handle);
    const auto count = static_cast<std::size_t>(size);
    try {
        if (file.bytes.size() < file.position + count) file.bytes.resize(file.position + count);
    } catch (const std::exception&) {
        return 0;
    }
    std::memcpy(file.bytes.data() + file.position, source, count);
    file.position += count;
    return size;
}

toff_t seek(thandle_t handle, toff_t offset, int whence) {
    MemoryFile& file = file_of(handle);
    const std::size_t base = whence == SEEK_CUR ? file.position : whence == SEEK_END ? file.bytes.size() : 0;
    return file.position = base + offset;
}

int close(thandle_t) {
    return 0;
}

toff_t size(thandle_t handle) {
    return file_of(handle).bytes.size();
}

int keep_quiet(TIFF*, void*, const char*, const char*, va_list) {
    return 1;
}

struct Close {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
    void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};
using Tiff = std::unique_ptr<TIFF, Close>;

Tiff open(MemoryFile& file) {
    const std::unique_ptr<TIFFOpenOptions, Close> options(TIFFOpenOptionsAlloc());
    if (!options) return nullptr;
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_quiet, nullptr);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), keep_quiet, nullptr);
    // The mode wl writes little-endian files on every machine.
    return Tiff(TIFFClientOpenExt("", "wl", &file, read, write, seek, close, size, nullptr, nullptr, options.get()));
}

/// Layout of stored pixels.
struct Layout {
    int width = 0;
    int height = 0;
    bool bilevel = false;
    std::uint16_t channels = 1;
    std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
    Shades shades{};              ///< colour of each value of the picture
    bool true_colour = false;     ///< whether the values of the picture are stored unchanged
    std::span<const Ink> inks{};  ///< [channels] inks of the plates; empty: the channels are colours
};

/// Fills a row of the file. The length of the row follows from the layout.
using FillRow = std::function<void(int y, std::uint8_t* row)>;

Layout layout_of(const DotImage& image) {
    Layout layout;
    layout.width = image.width;
    layout.height = image.height;
    layout.shades = image.palette;
    layout.true_colour = image.colours == 0;
    layout.bilevel = image.is_bilevel();
    if (!image.grey) {
        layout.channels = image.transparent ? 4 : 3;
        layout.photometric = PHOTOMETRIC_RGB;
    } else if (layout.bilevel && image.palette[0][0] == 255) {
        layout.photometric = PHOTOMETRIC_MINISWHITE;
    }
    return layout;
}

Layout layout_of(std::span<const Raster> plates, std::span<const Ink> inks) {
    Layout layout;
    layout.width = plates.front().width;
    layout.height = plates.front().height;
    layout.channels = static_cast<std::uint16_t>(plates.size());
    layout.photometric = PHOTOMETRIC_SEPARATED;
    layout.inks = inks;
    return layout;
}

/// Converts a row of values to a row of the file. In a bilevel file, a set bit is a dot.
void pack_row(const std::uint8_t* values, std::size_t count, const Layout& layout, std::uint8_t* row) {
    if (layout.true_colour) {
        std::copy_n(values, count, row);
        return;
    }
    if (layout.bilevel) {
        std::fill(row, row + (count + 7) / 8, std::uint8_t{0});
        for (std::size_t x = 0; x < count; ++x) {
            if (values[x] != 0) row[x / 8] = static_cast<std::uint8_t>(row[x / 8] | 128U >> x % 8);
        }
        return;
    }
    for (std::size_t x = 0; x < count; ++x) row = std::copy_n(layout.shades[values[x]].begin(), layout.channels, row);
}

/// Interleaves the values of all plates in a row.
void interleave_row(std::span<const Raster> plates, int y, std::uint8_t* row) {
    const auto width = static_cast<std::size_t>(plates.front().width);
    for (std::size_t plate = 0; plate < plates.size(); ++plate) {
        const std::uint8_t* const values = plates[plate].coverage.data() + static_cast<std::size_t>(y) * width;
        for (std::size_t x = 0; x < width; ++x) row[x * plates.size() + plate] = values[x];
    }
}

/// Writes the ink tags, with the names of the inks, each terminated by a zero.
bool write_inks(TIFF* tiff, std::span<const Ink> inks) {
    std::string names;
    for (const Ink& ink : inks) names.append(ink.name).push_back('\0');
    return TIFFSetField(tiff, TIFFTAG_INKSET, is_cmyk(inks) ? INKSET_CMYK : INKSET_MULTIINK) &&
           TIFFSetField(tiff, TIFFTAG_NUMBEROFINKS, static_cast<int>(inks.size())) &&
           TIFFSetField(tiff, TIFFTAG_INKNAMES, static_cast<int>(names.size()), names.data());
}

bool write_header(TIFF* tiff, const Layout& layout, std::optional<double> width_mm) {
    const std::uint16_t alpha = EXTRASAMPLE_UNASSALPHA;
    const double resolution = width_mm ? layout.width / *width_mm * kMillimetresPerInch : 1;
    return TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(layout.width)) &&
           TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(layout.height)) &&
           TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, layout.bilevel ? 1 : 8) &&
           TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, layout.channels) &&
           TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, layout.photometric) &&
           (layout.inks.empty() || write_inks(tiff, layout.inks)) &&
           (layout.photometric != PHOTOMETRIC_RGB || layout.channels < 4 ||
            TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &alpha)) &&
           TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) &&
           TIFFSetField(tiff, TIFFTAG_COMPRESSION,
                        layout.bilevel ? COMPRESSION_CCITTFAX4 : COMPRESSION_ADOBE_DEFLATE) &&
           (layout.bilevel || TIFFSetField(tiff, TIFFTAG_ZIPQUALITY, 1)) &&
           TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, width_mm ? RESUNIT_INCH : RESUNIT_NONE) &&
           TIFFSetField(tiff, TIFFTAG_XRESOLUTION, resolution) && TIFFSetField(tiff, TIFFTAG_YRESOLUTION, resolution) &&
           TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff, 0));
}

bool write_rows(TIFF* tiff, const Layout& layout, const FillRow& fill, const std::stop_token& stop) {
    std::vector<std::uint8_t> row(static_cast<std::size_t>(layout.width) * layout.channels);
    for (int y = 0; y < layout.height; ++y) {
        if (stop.stop_requested()) return false;
        fill(y, row.data());
        if (TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0) < 0) return false;
    }
    return TIFFFlush(tiff) != 0;
}

Result<std::string> write_file(const Layout& layout, const FillRow& fill, std::optional<double> width_mm,
                               const std::stop_token& stop) {
    MemoryFile file;
    Tiff tiff = open(file);
    const bool written =
        tiff && write_header(tiff.get(), layout, width_mm) && write_rows(tiff.get(), layout, fill, stop);
    tiff.reset();
    if (written) return std::move(file.bytes);
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped while the picture was encoded");
    return failure(ErrorCode::Internal, "the picture could not be encoded");
}

}  // namespace

Result<std::string> write_tiff(const DotImage& image, std::optional<double> width_mm, const std::stop_token& stop) {
    const Layout layout = layout_of(image);
    const auto fill = [&](int y, std::uint8_t* row) { pack_row(image.row(y), image.row_size(), layout, row); };
    return write_file(layout, fill, width_mm, stop);
}

Result<std::string> write_tiff_plates(std::span<const Raster> plates, std::span<const Ink> inks,
                                      std::optional<double> width_mm, const std::stop_token& stop) {
    const auto fill = [&](int y, std::uint8_t* row) { interleave_row(plates, y, row); };
    return write_file(layout_of(plates, inks), fill, width_mm, stop);
}

}  // namespace ccdt::api
