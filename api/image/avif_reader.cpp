// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/avif_reader.h"

#include <avif/avif.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "api/image/broken_image.h"
#include "api/image/containers.h"
#include "api/image/heif_properties.h"

namespace ccdt::api {
namespace {

using Decoder = std::unique_ptr<avifDecoder, decltype(&avifDecoderDestroy)>;

/// Returns a copy of a file that version 0.11 of the library reads. In the copy, the last box states its size, and
/// tracks are hidden, because the library refuses tracks without width and height, such as sound. Returns an empty
/// string if the file needs no change.
std::string repair(std::string_view bytes) {
    std::string copy;
    const auto write = [&](std::size_t at, std::string_view text) {
        if (copy.empty()) copy = bytes;
        copy.replace(at, text.size(), text);
    };
    for (auto box = media_box(bytes, 0); box; box = media_box(bytes, box->end)) {
        const auto size = static_cast<std::uint32_t>(box->end - box->begin);
        const auto byte = [&](int shift) { return static_cast<char>(size >> shift); };
        if (ByteReader(bytes, true).read(box->begin, 4) == 0U)
            write(box->begin, std::string{byte(24), byte(16), byte(8), byte(0)});
        if (box->name != "moov") continue;
        for (auto track = media_box(box->data, 0); track; track = media_box(box->data, track->end)) {
            if (track->name == "trak") write(static_cast<std::size_t>(track->name.data() - bytes.data()), "free");
        }
    }
    return copy;
}

/// Creates a decoder of the primary item. Other items, such as gain maps, and the frames of an animation may be larger.
Decoder make_decoder(std::string_view bytes) {
    Decoder decoder(avifDecoderCreate(), avifDecoderDestroy);
    decoder->codecChoice = AVIF_CODEC_CHOICE_DAV1D;
    decoder->maxThreads = 1;
    decoder->ignoreExif = AVIF_TRUE;
    decoder->ignoreXMP = AVIF_TRUE;
    decoder->imageSizeLimit = AVIF_DEFAULT_IMAGE_SIZE_LIMIT;
    decoder->imageDimensionLimit = kMaxAvifSide;
    // Many files lack the property pixi, and browsers show them.
    // The reader of the header checks crops. Unlike the library, it allows those that divide blocks of chroma.
    decoder->strictFlags =
        AVIF_STRICT_ENABLED & ~static_cast<avifStrictFlags>(AVIF_STRICT_PIXI_REQUIRED | AVIF_STRICT_CLAP_VALID);
    avifDecoderSetSource(decoder.get(), AVIF_DECODER_SOURCE_PRIMARY_ITEM);
    avifDecoderSetIOMemory(decoder.get(), reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    return decoder;
}

/// Interleaved pixels of the picture: red, green, blue and, if the picture has it, alpha.
class Pixels {
public:
    Pixels() = default;
    ~Pixels() { avifRGBImageFreePixels(&rgb_); }
    Pixels(const Pixels&) = delete;
    Pixels& operator=(const Pixels&) = delete;

    bool convert(const avifImage& image) {
        avifRGBImageSetDefaults(&rgb_, &image);
        rgb_.depth = image.depth > 8 ? 16 : 8;
        rgb_.format = image.alphaPlane != nullptr ? AVIF_RGB_FORMAT_RGBA : AVIF_RGB_FORMAT_RGB;
        rgb_.alphaPremultiplied = image.alphaPremultiplied;
        rgb_.avoidLibYUV = AVIF_TRUE;  // libyuv would round intermediate results to fewer bits
        rgb_.chromaUpsampling = AVIF_CHROMA_UPSAMPLING_BILINEAR;
        is_grey_ = image.yuvFormat == AVIF_PIXEL_FORMAT_YUV400;
        avifRGBImageAllocatePixels(&rgb_);
        return avifImageYUVToRGB(&image, &rgb_) == AVIF_RESULT_OK;
    }

    bool has_alpha() const { return rgb_.format == AVIF_RGB_FORMAT_RGBA; }
    int channels() const { return (is_grey_ ? 1 : 3) + (has_alpha() ? 1 : 0); }

    /// Reads rows of the part that is shown.
    template <class Sample>
    void read(const HeifView& view, int begin, int end, Sample* to) const {
        const std::size_t stored = has_alpha() ? 4 : 3;
        const std::size_t colours = is_grey_ ? 1 : 3;
        for (auto y = static_cast<std::size_t>(begin); y < static_cast<std::size_t>(end); ++y) {
            const auto* row = reinterpret_cast<const Sample*>(rgb_.pixels + (view.top + y) * rgb_.rowBytes);
            const Sample* pixel = row + view.left * stored;
            for (std::uint32_t x = 0; x < view.width; ++x, pixel += stored) {
                to = std::copy_n(pixel, colours, to);
                if (has_alpha()) *to++ = pixel[3];
            }
        }
    }

private:
    avifRGBImage rgb_{};
    bool is_grey_ = false;
};

tl::unexpected<Error> not_read(const std::string& kind) {
    return failure(ErrorCode::Unusable, "there is no support for this kind of image: an AVIF with " + kind);
}

}  // namespace

Result<RowSource> open_avif(std::string_view bytes, const ImageHeader& header) {
    constexpr int kRows = 16;
    const std::string repaired = repair(bytes);
    const Decoder decoder = make_decoder(repaired.empty() ? bytes : repaired);
    if (avifDecoderParse(decoder.get()) != AVIF_RESULT_OK) return broken_image();
    const avifImage& image = *decoder->image;
    const HeifView& view = header.view;
    const auto has_whole_size = [&] { return image.width == view.whole_width && image.height == view.whole_height; };
    if (!has_whole_size()) return broken_image();
    if (const std::string_view grid = misread_grid(bytes); !grid.empty()) return not_read(std::string(grid));
    // The codec is opened below, with this limit.
    decoder->imageSizeLimit =
        static_cast<std::uint32_t>(std::min<std::uint64_t>(view.whole_pixels(), decoder->imageSizeLimit));
    if (avifDecoderNextImage(decoder.get()) != AVIF_RESULT_OK || !has_whole_size()) return broken_image();
    const auto pixels = std::make_shared<Pixels>();
    if (!pixels->convert(image))
        return not_read("the matrix " + std::to_string(image.matrixCoefficients) + " of H.273");

    RowSource source;
    source.width = static_cast<int>(view.width);
    source.height = static_cast<int>(view.height);
    source.channels = pixels->channels();
    source.alpha = pixels->has_alpha() ? source.channels - 1 : -1;
    source.premultiplied = pixels->has_alpha() && image.alphaPremultiplied != AVIF_FALSE;
    source.sample = image.depth > 8 ? RowSource::Sample::Word : RowSource::Sample::Byte;
    source.code_points = {static_cast<std::uint8_t>(image.colorPrimaries),
                          static_cast<std::uint8_t>(image.transferCharacteristics)};
    source.orientation = view.orientation;
    source.step = kRows;
    source.read = [pixels, view, sample = source.sample](int begin, int end, void* rows) {
        if (sample == RowSource::Sample::Byte) {
            pixels->read(view, begin, end, static_cast<std::uint8_t*>(rows));
        } else {
            pixels->read(view, begin, end, static_cast<std::uint16_t*>(rows));
        }
        return true;
    };
    return source;
}

}  // namespace ccdt::api
