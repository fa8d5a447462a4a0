// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/heic_reader.h"

#include <libde265/de265.h>
#include <libheif/heif.h>
#include <libheif/heif_plugin.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>

#include "api/image/broken_image.h"

namespace ccdt::api {
namespace {

// A decoder for libheif that runs in the calling thread. The decoder of libheif starts a thread, which a sandboxed
// process cannot do: the decoder would wait for this thread forever.

constexpr heif_error kDone{heif_error_Ok, heif_suberror_Unspecified, "Success"};
constexpr heif_error kBroken{heif_error_Decoder_plugin_error, heif_suberror_Unspecified, "broken HEVC"};

/// Maximum number of pixels of one coded picture, such as a tile.
constexpr std::int64_t kMaxCodedPixels = std::int64_t{1} << 28;

constexpr int kPlanes = 3;

/// Allocates the planes of a picture and clears them, because parts of a broken picture are not written.
int allocate(de265_decoder_context* context, de265_image_spec* spec, de265_image* picture, void* user) {
    if (std::int64_t{spec->width} * spec->height > kMaxCodedPixels) return 0;
    if (de265_get_default_image_allocation_functions()->get_buffer(context, spec, picture, user) == 0) return 0;
    for (int plane = 0; plane < kPlanes; ++plane) {
        int stride = 0;
        // Writable until it is decoded.
        auto* const samples = const_cast<std::uint8_t*>(de265_get_image_plane(picture, plane, &stride));
        const int height = de265_get_image_height(picture, plane);
        if (samples != nullptr && height > 0)
            std::memset(samples, 0, static_cast<std::size_t>(stride) * static_cast<std::size_t>(height));
    }
    return 1;
}

heif_error new_decoder(void** decoder) {
    de265_decoder_context* const context = de265_new_decoder();
    if (context == nullptr) return kBroken;
    de265_image_allocation allocation = *de265_get_default_image_allocation_functions();
    allocation.get_buffer = allocate;
    de265_set_image_allocation_functions(context, &allocation, nullptr);
    *decoder = context;
    return kDone;
}

void free_decoder(void* decoder) {
    de265_free_decoder(static_cast<de265_decoder_context*>(decoder));
}

/// Passes NAL units to the decoder. Each one begins with its size.
heif_error push_data(void* decoder, const void* data, std::size_t size) {
    constexpr std::size_t kSize = 4;
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    while (size >= kSize) {
        const std::uint32_t unit = std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
                                   std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]};
        bytes += kSize;
        size -= kSize;
        if (unit > size) return kBroken;
        auto* const context = static_cast<de265_decoder_context*>(decoder);
        if (de265_isOK(de265_push_NAL(context, bytes, static_cast<int>(unit), 0, nullptr)) == 0) return kBroken;
        bytes += unit;
        size -= unit;
    }
    return size == 0 ? kDone : kBroken;
}

/// Copies the rows of a plane to a plane of `to`.
bool copy_plane(const de265_image& from, int plane, heif_channel channel, heif_image* to) {
    const int width = de265_get_image_width(&from, plane), height = de265_get_image_height(&from, plane);
    const int bits = de265_get_bits_per_pixel(&from, plane);
    int from_stride = 0, to_stride = 0;
    const std::uint8_t* source = de265_get_image_plane(&from, plane, &from_stride);
    if (source == nullptr || width < 1 || height < 1) return false;
    if (heif_image_add_plane(to, channel, width, height, bits).code != heif_error_Ok) return false;
    std::uint8_t* target = heif_image_get_plane(to, channel, &to_stride);
    const std::size_t row = static_cast<std::size_t>(width) * (bits > 8 ? 2 : 1);
    for (int y = 0; y < height; ++y, source += from_stride, target += to_stride) std::memcpy(target, source, row);
    return true;
}

/// Sets the colours that the bitstream declares. They apply if the file does not declare colours.
void copy_colours(const de265_image& from, heif_image* to) {
    const std::unique_ptr<heif_color_profile_nclx, decltype(&heif_nclx_color_profile_free)> colours(
        heif_nclx_color_profile_alloc(), heif_nclx_color_profile_free);
    const auto number = [](int code) { return static_cast<std::uint16_t>(code); };
    colours->full_range_flag = de265_get_image_full_range_flag(&from) != 0 ? 1 : 0;
    heif_nclx_color_profile_set_matrix_coefficients(colours.get(), number(de265_get_image_matrix_coefficients(&from)));
    heif_nclx_color_profile_set_color_primaries(colours.get(), number(de265_get_image_colour_primaries(&from)));
    heif_nclx_color_profile_set_transfer_characteristics(colours.get(),
                                                         number(de265_get_image_transfer_characteristics(&from)));
    heif_image_set_nclx_color_profile(to, colours.get());
}

heif_error copy_picture(const de265_image& from, heif_image** to) {
    constexpr heif_chroma kChromas[] = {heif_chroma_monochrome, heif_chroma_420, heif_chroma_422, heif_chroma_444};
    constexpr heif_channel kChannels[] = {heif_channel_Y, heif_channel_Cb, heif_channel_Cr};
    const de265_chroma chroma = de265_get_chroma_format(&from);
    const bool is_grey = chroma == de265_chroma_mono;
    const heif_error made =
        heif_image_create(de265_get_image_width(&from, 0), de265_get_image_height(&from, 0),
                          is_grey ? heif_colorspace_monochrome : heif_colorspace_YCbCr, kChromas[chroma], to);
    if (made.code != heif_error_Ok) return made;
    for (int plane = 0; plane < (is_grey ? 1 : kPlanes); ++plane) {
        if (copy_plane(from, plane, kChannels[plane], *to)) continue;
        heif_image_release(*to);
        *to = nullptr;
        return kBroken;
    }
    copy_colours(from, *to);
    return kDone;
}

/// Decodes the first picture. A warning means that the picture is not complete.
heif_error decode_picture(void* decoder, heif_image** picture) {
    auto* const context = static_cast<de265_decoder_context*>(decoder);
    de265_flush_data(context);
    *picture = nullptr;
    int more = 1;
    while (more != 0 && de265_peek_next_picture(context) == nullptr) {
        if (de265_isOK(de265_decode(context, &more)) == 0) return kBroken;
    }
    for (de265_error warning = de265_get_warning(context); warning != DE265_OK; warning = de265_get_warning(context)) {
        if (warning != DE265_WARNING_NO_WPP_CANNOT_USE_MULTITHREADING) return kBroken;
    }
    const de265_image* const decoded = de265_peek_next_picture(context);
    return decoded == nullptr ? kBroken : copy_picture(*decoded, picture);
}

const heif_decoder_plugin kDecoder{
    .plugin_api_version = 3,
    .get_plugin_name = [] { return "libde265 without threads"; },
    .init_plugin = nullptr,
    .deinit_plugin = nullptr,
    .does_support_format =
        [](heif_compression_format format) {
            constexpr int kAboveOthers = 1000;
            return format == heif_compression_HEVC ? kAboveOthers : 0;
        },
    .new_decoder = new_decoder,
    .free_decoder = free_decoder,
    .push_data = push_data,
    .decode_image = decode_picture,
    .set_strict_decoding = [](void*, int) {},
    .id_name = "ccdt",
};

using Context = std::unique_ptr<heif_context, decltype(&heif_context_free)>;
using Handle = std::unique_ptr<heif_image_handle, decltype(&heif_image_handle_release)>;
using Image = std::shared_ptr<heif_image>;

/// Returns the error about a file, from an error of libheif.
tl::unexpected<Error> refuse(const heif_error& error) {
    if (error.code != heif_error_Unsupported_feature && error.code != heif_error_Unsupported_filetype)
        return broken_image();
    return failure(ErrorCode::Unusable,
                   "there is no support for this kind of image: a HEIC with features that libheif does not support");
}

/// Decodes an item, without its crop, rotation and mirroring, to interleaved red, green and blue and, if the item has
/// it, alpha. The library would mirror only samples of 8 bits.
Result<Image> decode(const heif_image_handle& handle) {
    const bool has_alpha = heif_image_handle_has_alpha_channel(&handle) != 0;
    const bool is_deep = heif_image_handle_get_luma_bits_per_pixel(&handle) > 8;
    const heif_chroma words = has_alpha ? heif_chroma_interleaved_RRGGBBAA_LE : heif_chroma_interleaved_RRGGBB_LE;
    const heif_chroma bytes = has_alpha ? heif_chroma_interleaved_RGBA : heif_chroma_interleaved_RGB;
    const std::unique_ptr<heif_decoding_options, decltype(&heif_decoding_options_free)> options(
        heif_decoding_options_alloc(), heif_decoding_options_free);
    options->ignore_transformations = 1;
    heif_image* image = nullptr;
    const heif_error decoded =
        heif_decode_image(&handle, &image, heif_colorspace_RGB, is_deep ? words : bytes, options.get());
    if (decoded.code != heif_error_Ok) return refuse(decoded);
    return Image(image, heif_image_release);
}

/// Converts a sample of `bits` bits, 9 to 16, to 16 bits.
std::uint16_t widen(const std::uint8_t* sample, int bits) {
    const std::uint32_t full = (1U << bits) - 1;
    const std::uint32_t value = std::min<std::uint32_t>(sample[0] | std::uint32_t{sample[1]} << 8, full);
    return static_cast<std::uint16_t>((value * 65535U + full / 2) / full);
}

}  // namespace

Result<RowSource> open_heic(std::string_view bytes, const ImageHeader& header) {
    constexpr int kRows = 16;
    const Context context(heif_context_alloc(), heif_context_free);
    if (!context) return broken_image();
    heif_context_set_max_decoding_threads(context.get(), 0);
    heif_register_decoder(context.get(), &kDecoder);
    const heif_error read =
        heif_context_read_from_memory_without_copy(context.get(), bytes.data(), bytes.size(), nullptr);
    if (read.code != heif_error_Ok) return refuse(read);
    heif_image_handle* primary = nullptr;
    if (const heif_error found = heif_context_get_primary_image_handle(context.get(), &primary);
        found.code != heif_error_Ok)
        return refuse(found);
    const Handle handle(primary, heif_image_handle_release);
    auto image = decode(*handle);
    if (!image) return tl::unexpected(image.error());

    const HeifView& view = header.view;
    int stride = 0;
    const std::uint8_t* const plane = heif_image_get_plane_readonly(image->get(), heif_channel_interleaved, &stride);
    if (plane == nullptr || heif_image_get_primary_width(image->get()) != static_cast<int>(view.whole_width) ||
        heif_image_get_primary_height(image->get()) != static_cast<int>(view.whole_height))
        return broken_image();
    RowSource source;
    source.width = static_cast<int>(view.width);
    source.height = static_cast<int>(view.height);
    source.orientation = view.orientation;
    const bool has_alpha = heif_image_handle_has_alpha_channel(handle.get()) != 0;
    const int bits = heif_image_get_bits_per_pixel_range(image->get(), heif_channel_interleaved);
    source.channels = has_alpha ? 4 : 3;
    source.alpha = has_alpha ? 3 : -1;
    source.premultiplied = has_alpha && heif_image_handle_is_premultiplied_alpha(handle.get()) != 0;
    source.sample = bits > 8 ? RowSource::Sample::Word : RowSource::Sample::Byte;
    source.step = kRows;
    const auto samples = static_cast<std::size_t>(source.width) * static_cast<std::size_t>(source.channels);
    const std::size_t sample_bytes = bits > 8 ? 2 : 1;
    const std::uint8_t* const first = plane + static_cast<std::ptrdiff_t>(view.top) * stride +
                                      view.left * static_cast<std::size_t>(source.channels) * sample_bytes;
    source.read = [image = *image, first, stride, bits, samples](int begin, int end, void* rows) {
        const std::uint8_t* row = first + static_cast<std::ptrdiff_t>(begin) * stride;
        auto* byte = static_cast<std::uint8_t*>(rows);
        auto* word = static_cast<std::uint16_t*>(rows);
        for (int y = begin; y < end; ++y, row += stride) {
            if (bits <= 8) {
                byte = std::copy_n(row, samples, byte);
                continue;
            }
            for (std::size_t i = 0; i < samples; ++i) *word++ = widen(row + 2 * i, bits);
        }
        return true;
    };
    return source;
}

}  // namespace ccdt::api
