// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/library_reader.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "api/image/broken_image.h"

namespace ccdt::api {
namespace {

const char* plugin_name(ImageFormat format) {
    switch (format) {
        case ImageFormat::Png:
            return "png";
        case ImageFormat::Jpeg:
            return "jpeg";
        case ImageFormat::WebP:
            return "webp";
        case ImageFormat::Tiff:
            return "tiff";
        case ImageFormat::Gif:
        case ImageFormat::Bmp:
        case ImageFormat::Avif:
            break;  // these formats have their own readers; OpenImageIO's AVIF reader starts threads
    }
    return "";
}

tl::unexpected<Error> unusual(const char* what) {
    return failure(ErrorCode::Unusable, std::string("the server does not read this kind of image: ") + what);
}

std::uint64_t pixels_of(int width, int height) {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
}

/// Checks that the library finds the same size as read_image_header(), and that it supports this kind of image.
Result<void> check_spec(const OIIO::ImageSpec& spec, const ImageHeader& header) {
    constexpr int kMaxChannels = 5;  // CMYK and alpha
    if (spec.width < 1 || spec.height < 1) return broken_image();
    if (pixels_of(spec.width, spec.height) != header.pixels()) return broken_image();
    if (spec.depth > 1 || spec.deep) return unusual("more than two dimensions");
    if (spec.nchannels < 1 || spec.nchannels > kMaxChannels) return unusual("an unusual number of channels");
    if (spec.tile_width > 0 && pixels_of(spec.tile_width, spec.tile_height) > header.pixels() + kMaxTilePixels)
        return unusual("tiles much larger than the picture");
    return {};
}

/// Returns whether OpenImageIO flips the rows of a TIFF regardless of its orientation, because it converts YCbCr.
bool is_converted_ycbcr(const OIIO::ImageSpec& spec) {
    constexpr int kYCbCr = 6;
    constexpr int kJpeg = 7;
    return spec.get_int_attribute("tiff:PhotometricInterpretation") == kYCbCr &&
           spec.get_int_attribute("tiff:Compression") != kJpeg;
}

OIIO::TypeDesc type_of(RowSource::Sample sample) {
    switch (sample) {
        case RowSource::Sample::Byte:
            return OIIO::TypeDesc::UINT8;
        case RowSource::Sample::Word:
            return OIIO::TypeDesc::UINT16;
        case RowSource::Sample::Float:
            break;
    }
    return OIIO::TypeDesc::FLOAT;
}

RowSource::Sample sample_of(const OIIO::ImageSpec& spec) {
    if (spec.format == OIIO::TypeDesc::UINT8) return RowSource::Sample::Byte;
    if (spec.format == OIIO::TypeDesc::UINT16) return RowSource::Sample::Word;
    return RowSource::Sample::Float;
}

/// Returns the number of rows to read at once: the rows of a tile or, without tiles, about a megabyte of rows.
int rows_at_once(const OIIO::ImageSpec& spec) {
    if (spec.tile_width > 0) return spec.tile_height;
    const std::uint64_t row_bytes =
        static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.nchannels) * 4;
    return static_cast<int>(std::clamp<std::uint64_t>((1 << 20) / row_bytes, 1, 256));
}

RowSource describe(const OIIO::ImageSpec& spec) {
    RowSource source;
    source.width = spec.width;
    source.height = spec.height;
    source.channels = spec.nchannels;
    source.sample = sample_of(spec);
    const std::string space =
        spec.get_string_attribute("oiio:ColorSpace", spec.format.is_floating_point() ? "linear" : "sRGB");
    const float gamma = spec.get_float_attribute("oiio:Gamma", 0);
    if (OIIO::Strutil::iequals(space, "linear")) {
        source.curve = RowSource::Curve::Linear;
    } else if (gamma > 0) {
        source.curve = RowSource::Curve::Gamma;
        source.gamma = gamma;
    }
    source.has_inks = OIIO::Strutil::iequals(space, "CMYK");
    source.alpha = source.has_inks ? -1 : spec.alpha_channel;  // OpenImageIO takes the channel of black for alpha
    source.premultiplied = source.alpha >= 0 && spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0;
    source.orientation = spec.get_int_attribute("Orientation", 1);
    source.step = rows_at_once(spec);
    return source;
}

/// An open file. The library keeps the error message of an input until it is fetched or the thread ends. The destructor
/// fetches and discards it.
struct OpenFile {
    OIIO::Filesystem::IOMemReader bytes;
    std::unique_ptr<OIIO::ImageInput> input;
    OIIO::ImageSpec spec = {};
    int page = 0;

    ~OpenFile() {
        if (input) static_cast<void>(input->geterror());
    }

    bool read_rows(int begin, int end, const OIIO::TypeDesc& type, void* rows) {
        // The library reads rows that need no conversion directly into the buffer. For other rows, it allocates 64 MiB.
        const bool as_stored = spec.format == type && spec.channelformats.empty();
        const OIIO::TypeDesc to = as_stored ? OIIO::TypeDesc::UNKNOWN : type;
        if (spec.tile_width == 0) return input->read_scanlines(page, 0, begin, end, 0, 0, spec.nchannels, to, rows);
        return input->read_tiles(page, 0, 0, spec.width, begin, end, 0, 1, 0, spec.nchannels, type, rows);
    }
};

void configure_library() {
    static std::once_flag once;
    std::call_once(once, [] {
        OIIO::attribute("threads", 1);          // a request has one core
        OIIO::attribute("try_all_readers", 0);  // only the allowed readers
    });
}

}  // namespace

Result<RowSource> open_by_library(std::string_view bytes, const ImageHeader& header, bool keep_inks, int page) {
    configure_library();
    const auto file = std::shared_ptr<OpenFile>(
        new OpenFile{{bytes.data(), bytes.size()}, OIIO::ImageInput::create(plugin_name(header.format))});
    if (!file->input) return failure(ErrorCode::Internal, "the image reader is missing");
    file->input->threads(1);
    file->input->set_ioproxy(&file->bytes);
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    if (keep_inks) wishes.attribute("oiio:RawColor", 1);
    if (!file->input->open("image", file->spec, wishes)) return broken_image();
    if (page > 0) {
        if (!file->input->seek_subimage(page, 0)) return broken_image();
        file->spec = file->input->spec();
        file->page = page;
        const auto [width, height] = std::pair(file->spec.width, file->spec.height);
        if (std::cmp_not_equal(width, header.width) || std::cmp_not_equal(height, header.height))
            return failure(ErrorCode::Unusable, "page " + std::to_string(page + 1) + " has " + std::to_string(width) +
                                                    " x " + std::to_string(height) + " pixels, but page 1 has " +
                                                    std::to_string(header.width) + " x " +
                                                    std::to_string(header.height));
    }
    if (auto checked = check_spec(file->spec, header); !checked) return tl::unexpected(checked.error());

    RowSource source = describe(file->spec);
    if (header.format == ImageFormat::WebP) source.orientation = webp_orientation(bytes);
    if (source.orientation != 1 && is_converted_ycbcr(file->spec)) return unusual("a rotated TIFF in YCbCr");
    source.read = [file, type = type_of(source.sample)](int begin, int end, void* rows) {
        // Reading a truncated file may return true although there is an error message.
        return file->read_rows(begin, end, type, rows) && !file->input->has_error();
    };
    return source;
}

}  // namespace ccdt::api
