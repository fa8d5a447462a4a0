// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/colour_tags.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "api/image/containers.h"
#include "api/image/heif_properties.h"

namespace ccdt::api {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kJpegMark = "ICC_PROFILE\0"sv;
constexpr std::uint32_t kTiffTag = 34675;

/// Inflates the profile in a PNG chunk.
/// @param data  data of the chunk: a name, a zero, a byte for the compression method, and the compressed profile
std::string inflate_profile(std::string_view data) {
    const std::size_t name = data.find('\0');
    if (name == std::string_view::npos || name + 2 > data.size() || data[name + 1] != 0) return {};
    data.remove_prefix(name + 2);
    // A profile begins with its own size, but this number cannot be trusted. Deflate compresses by a factor of at most
    // 1032, which limits the size of the result.
    std::string profile(std::min(kLongestProfile, data.size() * 1040 + 1024), '\0');
    auto size = static_cast<uLongf>(profile.size());
    const int end = uncompress(reinterpret_cast<Bytef*>(profile.data()), &size,
                               reinterpret_cast<const Bytef*>(data.data()), static_cast<uLong>(data.size()));
    if (end != Z_OK) return {};
    profile.resize(size);
    return profile;
}

std::optional<ColourTags::CodePoints> read_code_points(std::string_view data) {
    if (data.size() != 4 || data[2] != 0 || data[3] != 1)
        return std::nullopt;  // ignores code points for YCbCr or for a limited range
    return ColourTags::CodePoints{static_cast<std::uint8_t>(data[0]), static_cast<std::uint8_t>(data[1])};
}

std::optional<std::array<double, 8>> read_primaries(std::string_view data) {
    constexpr double kUnit = 100'000;
    const ByteReader reader(data, true);
    std::array<double, 8> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto value = reader.read(4 * i, 4);
        if (!value) return std::nullopt;
        values[i] = *value / kUnit;
    }
    return values;
}

/// Returns the exponent that a PNG gives, rounded to hundredths, so that an approximate 2.2 is 2.2.
std::optional<float> read_gamma(std::string_view data) {
    constexpr double kUnit = 100'000, kSteps = 100;
    const double inverse = ByteReader(data, true).read(0, 4).value_or(0) / kUnit;
    const auto gamma = static_cast<float>(inverse > 0 ? std::round(kSteps / inverse) / kSteps : 0);
    return gamma > 0 ? std::optional(gamma) : std::nullopt;
}

/// Reads the tags before the picture data of a PNG.
ColourTags read_png(std::string_view bytes) {
    ColourTags tags;
    bool is_srgb = false;
    std::size_t at = kPngChunks;
    for (auto chunk = png_chunk(bytes, at); chunk && chunk->name != "IDAT"; chunk = png_chunk(bytes, chunk->end)) {
        if (chunk->name == "iCCP" && tags.profile.empty()) tags.profile = inflate_profile(chunk->data);
        if (chunk->name == "cICP") tags.code_points = read_code_points(chunk->data);
        if (chunk->name == "cHRM") tags.primaries = read_primaries(chunk->data);
        if (chunk->name == "gAMA") tags.gamma = read_gamma(chunk->data);
        if (chunk->name == "sRGB") is_srgb = true;
    }
    constexpr std::uint8_t kUnspecified = 2;
    const bool has_curve = tags.code_points && tags.code_points->transfer != kUnspecified;
    if (is_srgb || has_curve || !tags.profile.empty()) {
        tags.primaries.reset();
        tags.gamma.reset();
    }
    return tags;
}

/// Joins the parts of the ICC profile in a JPEG. A profile may be split into several segments. Each of these segments
/// contains its number, from 1 on, and the total number of segments.
std::string read_jpeg(std::string_view bytes) {
    constexpr std::uint32_t kApp2 = 0xE2;
    std::vector<std::string_view> parts;
    std::size_t missing = 0;
    std::size_t at = kJpegSegments;
    for (auto segment = jpeg_segment(bytes, at); segment && segment->marker != kJpegScan;
         segment = jpeg_segment(bytes, segment->end)) {
        std::string_view data = segment->data;
        if (segment->marker != kApp2 || !data.starts_with(kJpegMark) || data.size() <= kJpegMark.size() + 2) continue;
        const auto number = static_cast<unsigned char>(data[kJpegMark.size()]);
        const auto count = static_cast<unsigned char>(data[kJpegMark.size() + 1]);
        if (parts.empty()) parts.resize(missing = count);
        if (parts.size() != count || number < 1 || number > count || !parts[number - 1].empty()) return {};
        parts[number - 1] = data.substr(kJpegMark.size() + 2);
        --missing;
    }
    std::string profile;
    if (missing > 0) return profile;
    for (const auto part : parts) profile += part;
    return profile;
}

std::string_view read_webp(std::string_view bytes) {
    for (auto chunk = riff_chunk(bytes, kRiffChunks); chunk; chunk = riff_chunk(bytes, chunk->end)) {
        if (chunk->name == "ICCP") return chunk->data;
    }
    return {};
}

/// Returns the profile in a BMP with a header of version 5. The header states the offset of the profile from the
/// beginning of the header.
std::string_view read_bmp(std::string_view bytes) {
    constexpr std::size_t kHeader = 14, kColourSpace = 56, kPlace = 112, kSize = 116;
    constexpr std::uint32_t kVersion5 = 124, kEmbedded = 0x4D424544;  // "MBED"
    const std::string_view header = bytes.substr(std::min(kHeader, bytes.size()));
    const ByteReader reader(header, false);
    if (reader.read(0, 4) != kVersion5 || reader.read(kColourSpace, 4) != kEmbedded) return {};
    const std::size_t begin = reader.read(kPlace, 4).value_or(0), size = reader.read(kSize, 4).value_or(0);
    return begin <= header.size() && size <= header.size() - begin ? header.substr(begin, size) : std::string_view();
}

bool is_heif_profile(const Chunk& property) {
    return property.name == "colr" && (property.data.starts_with("prof") || property.data.starts_with("rICC"));
}

/// Reads the tags of an AVIF or HEIC. Omits the code points if there is a profile, because there the profile takes
/// precedence.
ColourTags read_heif(std::string_view bytes) {
    constexpr std::size_t kType = 4;
    ColourTags tags;
    for (const Chunk& property : heif_properties(bytes)) {
        const ByteReader reader(property.data, true);
        const auto primaries = reader.read(kType, 2).value_or(256);
        const auto transfer = reader.read(kType + 2, 2).value_or(256);
        if (is_heif_profile(property)) {
            tags.profile = property.data.substr(kType);
        } else if (property.name == "colr" && property.data.starts_with("nclx") && primaries < 256 && transfer < 256) {
            tags.code_points = {static_cast<std::uint8_t>(primaries), static_cast<std::uint8_t>(transfer)};
        }
    }
    if (!tags.profile.empty()) tags.code_points.reset();
    return tags;
}

std::string without_chunks(std::string_view bytes, std::string_view name) {
    std::string kept(bytes.substr(0, kPngChunks));
    kept.reserve(bytes.size());
    for (auto chunk = png_chunk(bytes, kPngChunks); chunk; chunk = png_chunk(bytes, chunk->end)) {
        if (chunk->name != name) kept += bytes.substr(chunk->begin, chunk->end - chunk->begin);
    }
    return kept;
}

/// Returns a copy of a JPEG in which every occurrence of the mark of profile segments is overwritten. Changing only the
/// segments that read_jpeg() finds is not sufficient, because OpenImageIO may find others.
std::string without_marks(std::string_view bytes, std::string_view mark) {
    std::string kept(bytes);
    for (std::size_t at = kept.find(mark); at != std::string::npos; at = kept.find(mark, at)) kept[at] = '-';
    return kept;
}

}  // namespace

ColourTags read_colour_tags(std::string_view bytes, ImageFormat format) {
    ColourTags tags;
    switch (format) {
        case ImageFormat::Png:
            tags = read_png(bytes);
            break;
        case ImageFormat::Jpeg:
            tags.profile = read_jpeg(bytes);
            break;
        case ImageFormat::WebP:
            tags.profile = read_webp(bytes);
            break;
        case ImageFormat::Tiff:
            tags.profile = TiffDirectory(bytes).data(kTiffTag).value_or(std::string_view());
            break;
        case ImageFormat::Avif:
        case ImageFormat::Heic:
            tags = read_heif(bytes);
            break;
        case ImageFormat::Bmp:
            tags.profile = read_bmp(bytes);
            break;
        case ImageFormat::Gif:
            break;
    }
    if (tags.profile.size() > kLongestProfile) tags.profile.clear();
    return tags;
}

bool may_have_profile(std::string_view bytes, ImageFormat format) {
    const auto has_chunk = [&](auto chunk_at, std::size_t first, std::string_view name) {
        auto chunk = chunk_at(bytes, first);
        while (chunk && chunk->name != name) chunk = chunk_at(bytes, chunk->end);
        return chunk.has_value();
    };
    switch (format) {
        case ImageFormat::Png:
            return has_chunk(png_chunk, kPngChunks, "iCCP");
        case ImageFormat::Jpeg:
            return bytes.find(kJpegMark) != std::string_view::npos;
        case ImageFormat::WebP:
            return has_chunk(riff_chunk, kRiffChunks, "ICCP");
        case ImageFormat::Tiff:
            return TiffDirectory(bytes).has(kTiffTag);
        case ImageFormat::Avif:
        case ImageFormat::Heic:
            return std::ranges::any_of(heif_properties(bytes), is_heif_profile);
        case ImageFormat::Bmp:
            return !read_bmp(bytes).empty();
        case ImageFormat::Gif:
            break;
    }
    return false;
}

std::string hide_profile(std::string_view bytes, ImageFormat format) {
    if (!may_have_profile(bytes, format)) return {};
    switch (format) {
        case ImageFormat::Png:
            return without_chunks(bytes, "iCCP");
        case ImageFormat::Jpeg:
            return without_marks(bytes, kJpegMark);
        case ImageFormat::WebP:  // OpenImageIO ignores the profile of a WebP
        case ImageFormat::Tiff:
        case ImageFormat::Gif:
        case ImageFormat::Bmp:
        case ImageFormat::Avif:
        case ImageFormat::Heic:
            break;
    }
    return {};
}

}  // namespace ccdt::api
