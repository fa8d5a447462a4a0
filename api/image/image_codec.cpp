// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/image_codec.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "api/image/avif_reader.h"
#include "api/image/bmp_reader.h"
#include "api/image/broken_image.h"
#include "api/image/colour_profile.h"
#include "api/image/colour_tags.h"
#include "api/image/containers.h"
#include "api/image/gif_reader.h"
#include "api/image/heic_reader.h"
#include "api/image/image_header.h"
#include "api/image/ink_jpeg.h"
#include "api/image/library_reader.h"
#include "api/image/picture_reader.h"
#include "api/image/row_source.h"
#include "api/image/tiff_reader.h"

namespace ccdt::api {
namespace {

bool has_colours_of(const RowSource& source, const ColourConversion& conversion) {
    switch (conversion.space) {
        case ColourConversion::Space::Grey:
            return source.channels < 3;
        case ColourConversion::Space::Rgb:
            return source.channels >= 3 && source.space == RowSource::Space::Light;
        case ColourConversion::Space::Inks:
            return source.space == RowSource::Space::Inks;
        case ColourConversion::Space::Lab:
            return source.space == RowSource::Space::Lab;
    }
    return false;
}

/// @param keep_inks  whether a picture with inks keeps them; otherwise they are converted to red, green and blue
Result<RowSource> open(std::string_view bytes, const ImageHeader& header, bool keep_inks) {
    if (header.format == ImageFormat::Gif) return open_gif(bytes, header);
    if (header.format == ImageFormat::Bmp) return open_bmp(bytes);
    if (header.format == ImageFormat::Avif) return open_avif(bytes, header);
    if (header.format == ImageFormat::Heic) return open_heic(bytes, header);
    if (header.format == ImageFormat::Tiff)
        return open_tiff(bytes, header, keep_inks ? TiffUse::Inks : TiffUse::Light, TiffDirectory(bytes).begin());
    if (keep_inks && header.is_ink_jpeg) return open_ink_jpeg(bytes);
    return open_by_library(bytes, header);
}

/// Returns a copy of a file without the faults that viewers ignore; empty if the file has none.
std::string repair(std::string_view bytes, ImageFormat format) {
    if (format == ImageFormat::Jpeg) return repair_jpeg(bytes);
    const auto palette = format == ImageFormat::Png ? misplaced_palette(bytes) : std::nullopt;
    return palette ? std::string(bytes.substr(0, palette->begin)).append(bytes.substr(palette->end)) : std::string();
}

template <class AnyPicture>
Result<AnyPicture> read_file(std::string_view bytes, const ImageHeader& header, const Reading& reading,
                             const NewPlane& make_plane) {
    ColourTags tags = read_colour_tags(bytes, header.format);
    auto conversion = convert_colours(tags);
    const std::string repaired = repair(bytes, header.format);
    if (!repaired.empty()) bytes = repaired;
    const std::string copy = hide_profile(bytes, header.format);
    if (!copy.empty()) bytes = copy;
    auto source = open(bytes, header, conversion && conversion->space == ColourConversion::Space::Inks);
    if (!source) return tl::unexpected(source.error());
    if (source->code_points && !tags.code_points && tags.profile.empty()) {
        tags.code_points = source->code_points;
        conversion = convert_colours(tags);
    }
    if (tags.gamma) {
        source->curve = *tags.gamma == 1 ? RowSource::Curve::Linear : RowSource::Curve::Gamma;
        source->gamma = *tags.gamma;
    }
    if (source->space == RowSource::Space::Lab) conversion = convert_lab();
    if (conversion && conversion->grey && source->channels < 3)
        conversion = ColourConversion{ColourConversion::Space::Grey, {}, {conversion->grey}, {}, {}};
    if (conversion && !has_colours_of(*source, *conversion)) conversion.reset();
    if (conversion && conversion->transform) source = transform_rows(*std::move(source), conversion->transform);
    return read_picture<AnyPicture>(*source, conversion ? &*conversion : nullptr, reading, make_plane);
}

/// Reads the rows of a page without conversion of the samples.
/// @param values  [pixels] receives the samples
template <class Sample>
bool copy_rows(const RowSource& source, float* values) {
    std::vector<Sample> rows(static_cast<std::size_t>(source.width) * static_cast<std::size_t>(source.step));
    for (int begin = 0; begin < source.height; begin += source.step) {
        const int end = std::min(source.height, begin + source.step);
        if (!source.read(begin, end, rows.data())) return false;
        const auto count = static_cast<std::size_t>(end - begin) * static_cast<std::size_t>(source.width);
        values = std::transform(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(count), values,
                                [](Sample sample) { return static_cast<float>(sample); });
    }
    return true;
}

bool copy_page(const RowSource& source, float* values) {
    if (source.sample == RowSource::Sample::Byte) return copy_rows<std::uint8_t>(source, values);
    if (source.sample == RowSource::Sample::Word) return copy_rows<std::uint16_t>(source, values);
    return copy_rows<float>(source, values);
}

/// Checks that a page has the size of the first page.
Result<void> check_page_size(const TiffDirectory& page, const ImageHeader& header, const std::string& name) {
    const auto width = page.number(TiffDirectory::kWidth).value_or(0),
               height = page.number(TiffDirectory::kHeight).value_or(0);
    if (width == header.width && height == header.height) return {};
    return failure(ErrorCode::Unusable, name + " has " + std::to_string(width) + " x " + std::to_string(height) +
                                            " pixels, but page 1 has " + std::to_string(header.width) + " x " +
                                            std::to_string(header.height));
}

/// Reads the pages of a TIFF as the layers of a stack, one below the other.
Result<Picture> read_stack(std::string_view bytes, const ImageHeader& header, std::size_t max_pixels,
                           const NewPlane& make_plane) {
    if (header.format != ImageFormat::Tiff || header.pixels() * header.frames > max_pixels) return broken_image();
    const auto layer = static_cast<std::size_t>(header.pixels()), size = layer * header.frames;
    const std::shared_ptr<float[]> values = make_plane(size);
    std::optional<RowSource::Sample> sample;
    TiffDirectory directory(bytes);
    for (std::size_t page = 0; page < header.frames; ++page, directory = TiffDirectory(bytes, directory.next())) {
        const std::string name = "page " + std::to_string(page + 1);
        if (auto checked = check_page_size(directory, header, name); !checked) return tl::unexpected(checked.error());
        const auto source = open_tiff(bytes, header, TiffUse::Values, directory.begin());
        if (!source) return tl::unexpected(source.error());
        if (source->channels != 1) return failure(ErrorCode::Unusable, name + " is not grey");
        if (source->sample != sample.value_or(source->sample))
            return failure(ErrorCode::Unusable, name + " has samples of another type than page 1");
        sample = source->sample;
        if (!copy_page(*source, values.get() + page * layer)) return broken_image();
    }
    return Picture{static_cast<int>(header.width), static_cast<int>(size / header.width), Plane(values, size), {}};
}

template <class AnyPicture>
Result<AnyPicture> decode(std::string_view bytes, const Reading& reading, const NewPlane& make_plane) {
    const auto header = read_image_header(bytes, reading.max_pixels);
    if (!header) return tl::unexpected(header.error());
    try {
        if constexpr (std::is_same_v<AnyPicture, Picture>) {
            if (reading.is_stack) return read_stack(bytes, *header, reading.max_pixels, make_plane);
        }
        return read_file<AnyPicture>(bytes, *header, reading, make_plane);
    } catch (...) {
        return broken_image();
    }
}

}  // namespace

Result<Picture> decode_image(std::string_view bytes, const Reading& reading, const NewPlane& make_plane) {
    return decode<Picture>(bytes, reading, make_plane);
}

Result<ColourPicture> decode_colour_image(std::string_view bytes, const Reading& reading, const NewPlane& make_plane) {
    return decode<ColourPicture>(bytes, reading, make_plane);
}

}  // namespace ccdt::api
