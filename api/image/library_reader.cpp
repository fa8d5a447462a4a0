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
        case ImageFormat::Gif:
        case ImageFormat::Bmp:
        case ImageFormat::Avif:
        case ImageFormat::Heic:
            break;  // these formats have their own readers; OpenImageIO's reader of AVIF and HEIC starts threads
    }
    return "";
}

std::uint64_t pixels_of(int width, int height) {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
}

/// Returns whether the library finds the same size as read_image_header().
bool has_size_of(const OIIO::ImageSpec& spec, const ImageHeader& header) {
    return spec.width > 0 && spec.height > 0 && pixels_of(spec.width, spec.height) == header.pixels();
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

/// Returns the number of rows to read at once: about a megabyte.
int rows_at_once(const OIIO::ImageSpec& spec) {
    const std::uint64_t row_bytes =
        static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.nchannels) * 4;
    return static_cast<int>(std::clamp<std::uint64_t>((1 << 20) / row_bytes, 1, 256));
}

/// Describes the rows. Ignores the attributes of the library, which texts in a file can set.
RowSource describe(const OIIO::ImageSpec& spec) {
    RowSource source;
    source.width = spec.width;
    source.height = spec.height;
    source.channels = spec.nchannels;
    source.sample = sample_of(spec);
    source.alpha = spec.alpha_channel;
    source.step = rows_at_once(spec);
    return source;
}

/// An open file. The library keeps the error message of an input until it is fetched or the thread ends. The destructor
/// fetches and discards it.
struct OpenFile {
    OIIO::Filesystem::IOMemReader bytes;
    std::unique_ptr<OIIO::ImageInput> input;
    OIIO::ImageSpec spec = {};

    ~OpenFile() {
        if (input) static_cast<void>(input->geterror());
    }

    bool read_rows(int begin, int end, const OIIO::TypeDesc& type, void* rows) {
        // The library reads rows that need no conversion directly into the buffer. For other rows, it allocates 64 MiB.
        const bool as_stored = spec.format == type && spec.channelformats.empty();
        // The number of the first row is the offset of the image on its page (oFFs in a PNG).
        return input->read_scanlines(0, 0, spec.y + begin, spec.y + end, 0, 0, spec.nchannels,
                                     as_stored ? OIIO::TypeDesc::UNKNOWN : type, rows);
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

Result<RowSource> open_by_library(std::string_view bytes, const ImageHeader& header) {
    configure_library();
    const auto file = std::shared_ptr<OpenFile>(
        new OpenFile{{bytes.data(), bytes.size()}, OIIO::ImageInput::create(plugin_name(header.format))});
    if (!file->input) return failure(ErrorCode::Internal, "the image reader is missing");
    file->input->threads(1);
    file->input->set_ioproxy(&file->bytes);
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    if (!file->input->open("image", file->spec, wishes)) return broken_image();
    if (!has_size_of(file->spec, header)) return broken_image();

    RowSource source = describe(file->spec);
    // The reader of WebP ignores the wish for colours that are not premultiplied.
    source.premultiplied = source.alpha >= 0 && header.format == ImageFormat::WebP;
    source.orientation = exif_orientation(bytes, header.format);
    source.read = [file, type = type_of(source.sample)](int begin, int end, void* rows) {
        // Reading a truncated file may return true although there is an error message.
        return file->read_rows(begin, end, type, rows) && !file->input->has_error();
    };
    return source;
}

}  // namespace ccdt::api
