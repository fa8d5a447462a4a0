// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/image_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "api/image/broken_image.h"
#include "api/image/colour_tags.h"
#include "api/image/containers.h"
#include "api/text/file_kind.h"

namespace ccdt::api {
namespace {

using std::uint64_t;

constexpr uint64_t kReaderBytes = uint64_t{16} << 20;   ///< bytes that decoding any file needs
constexpr uint64_t kProfileBytes = uint64_t{32} << 20;  ///< bytes for the tables of a profile
constexpr uint64_t kRowBytes = 48;                      ///< bytes for the rows being read, per pixel of the width

/// Returns whether all chunks up to the last one are complete. OpenImageIO leaks memory if a chunk is incomplete.
bool is_whole_png(std::string_view bytes) {
    std::size_t at = kPngChunks;
    while (const auto chunk = png_chunk(bytes, at)) {
        if (chunk->name == "IEND") return true;
        at = chunk->end;
    }
    return false;
}

/// Reads the header of a PNG, whose rows are decoded one by one unless they are interlaced.
Result<ImageHeader> read_png(std::string_view bytes) {
    constexpr uint64_t kChannels[] = {1, 1, 3, 3, 2, 1, 4};  // by colour type; a palette is converted to three channels
    constexpr std::uint32_t kHeaderChunk = 0x49484452;       // IHDR
    const ByteReader reader(bytes, true);
    const auto width = reader.read(16, 4);
    const auto height = reader.read(20, 4);
    const auto depth = reader.read(24, 1);
    const auto colour = reader.read(25, 1);
    const auto interlaced = reader.read(28, 1);
    if (reader.read(12, 4) != kHeaderChunk || !interlaced || *colour > 6 || !is_whole_png(bytes)) return broken_image();
    ImageHeader header{ImageFormat::Png, *width, *height, 0};
    const uint64_t sample = *depth > 8 ? 2 : 1;
    // One more channel is needed, because the chunk tRNS may add alpha to any colour type.
    if (*interlaced != 0) header.decoder_bytes = header.pixels() * (kChannels[*colour] + 1) * sample;
    if (misplaced_palette(bytes)) header.decoder_bytes += bytes.size();  // for a copy without the palette
    return header;
}

/// Maximum number of scans of a JPEG. A scan of a few bytes may cost a pass over the picture. Encoders write about ten.
constexpr int kMaxScans = 100;

/// Returns the offset of the marker after entropy-coded data. This marker begins with the first 0xFF that is not
/// followed by a zero and is not part of a restart marker.
std::size_t end_of_scan(std::string_view bytes, std::size_t at) {
    while ((at = bytes.find('\xff', at)) < bytes.size() - 1) {
        const auto next = static_cast<unsigned char>(bytes[at + 1]);
        if (next != 0 && (next < 0xD0 || next > 0xD7)) return at;
        at += 2;
    }
    return bytes.size();
}

/// Returns whether a JPEG has too many scans.
/// @param at  offset after the frame header
bool has_too_many_scans(std::string_view bytes, std::size_t at) {
    int scans = 0;
    while (const auto segment = jpeg_segment(bytes, at)) {
        if (segment->marker == kJpegEnd) break;
        if (segment->marker == kJpegScan && ++scans > kMaxScans) return true;
        at = end_of_scan(bytes, segment->end);
    }
    return false;
}

/// Reads the header of a JPEG. Rows are decoded one by one. If the picture has several scans, the decoder keeps all
/// coefficients.
Result<ImageHeader> read_jpeg(std::string_view bytes) {
    const auto frame = jpeg_frame(bytes);
    if (!frame) return broken_image();
    const ByteReader reader(frame->data, true);
    const auto height = reader.read(1, 2);
    const auto width = reader.read(3, 2);
    const auto channels = reader.read(5, 1);
    if (!channels) return broken_image();
    if (const std::string kind = unread_jpeg(*frame); !kind.empty())
        return failure(ErrorCode::Unusable, "there is no support for this kind of image: " + kind);
    ImageHeader header{ImageFormat::Jpeg, *width, *height, 0};
    // A baseline picture may have several scans, too. Its frame header does not state the number.
    constexpr uint64_t kCoefficient = 2;  // bytes
    constexpr uint64_t kBlock = 16;       // pixels; sides are rounded up to a multiple of this number
    header.decoder_bytes = (header.width + kBlock) * (header.height + kBlock) * *channels * kCoefficient;
    header.decoder_bytes += bytes.size();  // for a copy without faults
    header.is_ink_jpeg = *channels == 4;
    if (has_too_many_scans(bytes, frame->end))
        return failure(ErrorCode::Unusable,
                       "the image is a JPEG with more than " + std::to_string(kMaxScans) + " scans");
    return header;
}

constexpr std::size_t kRiffHeader = 8;  ///< size of a chunk's header: its name and its size

Result<ImageHeader> read_webp(std::string_view bytes) {
    // Bytes per pixel: two canvases of an animation, one frame, and references of lossless coding.
    constexpr uint64_t kDecoderBytes = 12;
    const ByteReader reader(bytes, false);
    const std::string_view chunk = bytes.substr(std::min(kRiffChunks, bytes.size()), 4);
    const std::size_t data = kRiffChunks + kRiffHeader;
    ImageHeader header{ImageFormat::WebP, 0, 0, 0};
    if (chunk == "VP8X") {
        const auto width = reader.read(data + 4, 3);
        const auto height = reader.read(data + 7, 3);
        if (width && height) header = {header.format, *width + uint64_t{1}, *height + uint64_t{1}, 0};
    } else if (chunk == "VP8L") {
        const auto bits = reader.read(data + 1, 4);
        if (bits) header = {header.format, (*bits & 0x3FFF) + uint64_t{1}, (*bits >> 14 & 0x3FFF) + uint64_t{1}, 0};
    } else if (chunk == "VP8 ") {
        const auto width = reader.read(data + 6, 2);
        const auto height = reader.read(data + 8, 2);
        if (width && height) header = {header.format, *width & 0x3FFF, *height & 0x3FFF, 0};
    }
    header.decoder_bytes = header.pixels() * kDecoderBytes;
    return header;
}

namespace tiff {
constexpr std::uint32_t kBitsPerSample = 258;
constexpr std::uint32_t kCompression = 259;
constexpr std::uint32_t kOrientation = 274;
constexpr std::uint32_t kSamplesPerPixel = 277;
constexpr std::uint32_t kRowsPerStrip = 278;
constexpr std::uint32_t kTileWidth = 322;
constexpr std::uint32_t kTileHeight = 323;
constexpr std::uint32_t kLzma = 34925;
constexpr std::uint32_t kZstandard = 50000;
}  // namespace tiff

/// Reads the header of a TIFF, whose strips or rows of tiles are decoded one by one. A strip may be the whole picture.
Result<ImageHeader> read_tiff(std::string_view bytes) {
    constexpr uint64_t kDictionary = uint64_t{72} << 20;  // bytes of the largest usual dictionary, with a margin
    const TiffDirectory directory(bytes);
    const auto width = directory.number(TiffDirectory::kWidth);
    const auto height = directory.number(TiffDirectory::kHeight);
    if (!width || !height) return broken_image();
    ImageHeader header{ImageFormat::Tiff, *width, *height, 0};
    const uint64_t most = header.pixels() + kMaxTilePixels;
    const uint64_t columns = directory.number(tiff::kTileWidth).value_or(*width);
    const uint64_t rows =
        directory.number(tiff::kTileHeight).value_or(directory.number(tiff::kRowsPerStrip).value_or(*height));
    const uint64_t band_rows = std::min<uint64_t>(rows, *height);
    // The reader refuses larger blocks, so the band has at most twice as many pixels.
    const uint64_t block = std::min(columns * rows, most), band = std::min((*width + columns) * band_rows, 2 * most);
    const uint64_t samples = std::min(directory.number(tiff::kSamplesPerPixel).value_or(1), kMaxTiffSamples);
    const uint64_t pixel = samples * std::clamp((directory.number(tiff::kBitsPerSample).value_or(1) + 7) / 8, 1U, 8U);
    // The codec and the reader may each have a copy of a block.
    header.decoder_bytes = (2 * block + band) * pixel;
    const auto compression = directory.number(tiff::kCompression);
    if (compression == tiff::kLzma || compression == tiff::kZstandard) header.decoder_bytes += kDictionary;
    return header;
}

/// Returns the size in bytes of a GIF's colour table, from the byte of flags that describes the table.
std::size_t gif_table(std::uint32_t packed) {
    return (packed & 0x80) == 0 ? 0 : std::size_t{3} << ((packed & 7) + 1);
}

/// Returns the offset of the description of a GIF's next frame; none after the last frame, and at an incomplete block.
/// @param at  offset of a block; receives the offset of the block after the frame
std::optional<std::size_t> next_gif_frame(std::string_view bytes, std::size_t& at) {
    constexpr std::uint32_t kExtension = 0x21, kImage = 0x2C;
    constexpr std::size_t kDescriptor = 10;
    const ByteReader reader(bytes, false);
    while (const auto block = reader.read(at, 1)) {
        const std::size_t begin = at;
        if (*block == kImage) {
            at += kDescriptor + gif_table(reader.read(at + 9, 1).value_or(0)) + 1;
        } else if (*block == kExtension) {
            at += 2;
        } else {
            break;
        }
        while (const auto size = reader.read(at, 1)) {
            at += 1 + *size;
            if (*size == 0) break;
        }
        if (*block == kImage) return begin + 1;
    }
    return std::nullopt;
}

/// Returns the offset of the first block of a GIF after the description of the screen.
std::size_t gif_blocks(std::string_view bytes) {
    constexpr std::size_t kScreen = 13;
    return kScreen + gif_table(ByteReader(bytes, false).read(10, 1).value_or(0));
}

/// Reads the header of a GIF. Its first frame is decoded as a whole, to a byte per pixel.
Result<ImageHeader> read_gif(std::string_view bytes) {
    const ByteReader reader(bytes, false);
    const auto width = reader.read(6, 2);
    const auto height = reader.read(8, 2);
    if (!width || !height) return broken_image();
    ImageHeader header{ImageFormat::Gif, *width, *height, 0};
    std::size_t at = gif_blocks(bytes);
    if (const auto frame = next_gif_frame(bytes, at)) {
        const auto number = [&](std::size_t part) { return uint64_t{reader.read(*frame + part, 2).value_or(0)}; };
        header.width = std::max(header.width, number(0) + number(4));  // viewers extend the screen
        header.height = std::max(header.height, number(2) + number(6));
    }
    header.decoder_bytes = header.pixels();
    return header;
}

constexpr std::size_t kBmpInfo = 14;  ///< offset of the picture's header, which begins with the header's size

/// Reads the header of a BMP. Its rows are decoded one by one, unless they are run-length encoded.
Result<ImageHeader> read_bmp(std::string_view bytes) {
    constexpr std::uint32_t kOldInfo = 12;
    const ByteReader reader(bytes, false);
    const bool is_old = reader.read(kBmpInfo, 4) == kOldInfo;
    const auto width = reader.read(kBmpInfo + 4, is_old ? 2 : 4);
    const auto height = reader.read(kBmpInfo + (is_old ? 6 : 8), is_old ? 2 : 4);
    if (!width || !height) return broken_image();
    // The height is negative if rows are stored from the top.
    const std::int64_t rows = is_old ? std::int64_t{*height} : static_cast<std::int32_t>(*height);
    ImageHeader header{ImageFormat::Bmp, *width, static_cast<uint64_t>(rows < 0 ? -rows : rows), 0};
    header.decoder_bytes = header.pixels();
    return header;
}

/// Returns whether a box states that no channel has more than 8 bits.
bool has_bytes(const Chunk& bits) {
    constexpr std::size_t kVersion = 4;
    const ByteReader reader(bits.data, true);
    const auto channels = reader.read(kVersion, 1).value_or(0);
    for (std::size_t i = 1; i <= channels; ++i) {
        if (reader.read(kVersion + i, 1).value_or(16) > 8) return false;
    }
    return channels > 0;
}

/// Returns the bytes of a sample of the primary item of a HEIF.
uint64_t bytes_of_sample(std::span<const Chunk> properties) {
    const auto is_small = [](const Chunk& property) { return property.name == "pixi" && has_bytes(property); };
    return std::ranges::any_of(properties, is_small) ? 1 : 2;
}

/// Largest ratio of all pixels to those that a crop leaves. The limit of pixels is for the latter, but all are decoded.
constexpr uint64_t kMaxCropped = 4;

/// Reads the size of the primary item of a HEIF. The size is that after the crop.
/// @param kind  for messages
Result<ImageHeader> read_heif(std::string_view bytes, ImageFormat format, std::span<const Chunk> properties,
                              uint64_t longest_side, const std::string& kind) {
    if (properties.empty() && heif_frames(bytes) > 0)
        return failure(ErrorCode::Unusable, "there is no support for this kind of image: " + kind +
                                                " with an image sequence without a still picture");
    const auto view = heif_view(properties);
    if (!view)
        return failure(ErrorCode::Unusable,
                       "the image is " + kind + " with a crop (clap) beyond its pixels, or after its rotation");
    if (std::max(view->whole_width, view->whole_height) > longest_side) return broken_image();
    ImageHeader header{format, view->width, view->height, 0};
    header.view = *view;
    if (view->whole_pixels() > kMaxCropped * header.pixels() + kMaxTilePixels)
        return failure(ErrorCode::Unusable,
                       "the image is " + kind + " that shows less than a quarter of its pixels (clap)");
    return header;
}

/// Reads the header of an AVIF, which is decoded as a whole. The decoder may keep two copies, before and after adding
/// grain or joining tiles. The reader keeps one more copy.
Result<ImageHeader> read_avif(std::string_view bytes) {
    // Samples per pixel: three copies of three planes and of alpha, and the interleaved pixels.
    constexpr uint64_t kSamples = 3 * 3 + 3 + 4;
    constexpr uint64_t kTables = 3;    // bytes per pixel
    constexpr uint64_t kBorder = 160;  // pixels by which a side may be rounded up, with a margin
    const std::vector<Chunk> properties = heif_properties(bytes);
    auto header = read_heif(bytes, ImageFormat::Avif, properties, kMaxAvifSide, "an AVIF");
    if (!header) return header;
    const uint64_t bytes_of_pixel = kSamples * bytes_of_sample(properties) + kTables;
    header->decoder_bytes =
        (header->view.whole_width + kBorder) * (header->view.whole_height + kBorder) * bytes_of_pixel;
    header->decoder_bytes += bytes.size();  // for a copy that the library can read
    return header;
}

/// Reads the header of a HEIF other than an AVIF.
Result<ImageHeader> read_heic(std::string_view bytes) {
    constexpr uint64_t kSamples = 16;           // per pixel; at most 14 were measured
    constexpr uint64_t kTileBytes = 32U << 20;  // for the decoder, which keeps several pictures of the size of a tile
    const std::vector<std::string_view> types = heif_item_types(bytes);
    if (!types.empty() && std::ranges::find(types, "hvc1") == types.end())
        return failure(ErrorCode::Unusable,
                       "there is no support for this kind of image: a HEIF with a picture that is not coded in HEVC (" +
                           std::string(types[0]) + ')');
    const std::vector<Chunk> properties = heif_properties(bytes);
    auto header = read_heif(bytes, ImageFormat::Heic, properties, kMaxHeicSide, "a HEIC");
    if (!header) return header;
    header->decoder_bytes = header->view.whole_pixels() * kSamples * bytes_of_sample(properties) + kTileBytes;
    return header;
}

/// Returns the number of frames of an animated PNG. Source: PNG (ISO/IEC 15948), third edition, 11.3.6.
uint64_t png_frames(std::string_view bytes) {
    std::size_t at = kPngChunks;
    while (const auto chunk = png_chunk(bytes, at)) {
        if (chunk->name == "acTL") return ByteReader(chunk->data, true).read(0, 4).value_or(1);
        if (chunk->name == "IDAT") break;
        at = chunk->end;
    }
    return 1;
}

uint64_t webp_frames(std::string_view bytes) {
    uint64_t frames = 0;
    std::size_t at = kRiffChunks;
    while (const auto chunk = riff_chunk(bytes, at)) {
        if (chunk->name == "ANMF") ++frames;
        at = chunk->end;
    }
    return frames;
}

/// Counts the pages of a TIFF. If the list of directories is circular, the count ends at a maximum.
uint64_t tiff_pages(std::string_view bytes) {
    constexpr uint64_t kMax = 65'535;
    uint64_t pages = 0;
    for (TiffDirectory page(bytes); page.begin() != 0 && pages < kMax; page = TiffDirectory(bytes, page.next()))
        ++pages;
    return pages;
}

uint64_t gif_frames(std::string_view bytes) {
    uint64_t frames = 0;
    std::size_t at = gif_blocks(bytes);
    while (next_gif_frame(bytes, at)) ++frames;
    return frames;
}

uint64_t count_frames(std::string_view bytes, ImageFormat format) {
    switch (format) {
        case ImageFormat::Png:
            return png_frames(bytes);
        case ImageFormat::WebP:
            return webp_frames(bytes);
        case ImageFormat::Tiff:
            return tiff_pages(bytes);
        case ImageFormat::Gif:
            return gif_frames(bytes);
        case ImageFormat::Avif:
        case ImageFormat::Heic:
            return heif_frames(bytes);
        case ImageFormat::Jpeg:
        case ImageFormat::Bmp:
            break;
    }
    return 1;
}

Result<ImageHeader> read(std::string_view bytes, ImageFormat format) {
    switch (format) {
        case ImageFormat::Png:
            return read_png(bytes);
        case ImageFormat::Jpeg:
            return read_jpeg(bytes);
        case ImageFormat::WebP:
            return read_webp(bytes);
        case ImageFormat::Tiff:
            return read_tiff(bytes);
        case ImageFormat::Gif:
            return read_gif(bytes);
        case ImageFormat::Bmp:
            return read_bmp(bytes);
        case ImageFormat::Avif:
            return read_avif(bytes);
        case ImageFormat::Heic:
            return read_heic(bytes);
    }
    return broken_image();
}

using namespace std::string_view_literals;

/// Returns whether a file is a BMP. Also checks the size of the header, since a text may begin with "BM", too.
bool is_bmp(std::string_view bytes) {
    constexpr std::array<std::uint32_t, 8> kInfoSizes = {12, 16, 40, 52, 56, 64, 108, 124};
    const auto size = ByteReader(bytes, false).read(kBmpInfo, 4);
    return bytes.starts_with("BM") && size && std::ranges::find(kInfoSizes, *size) != kInfoSizes.end();
}

/// Returns the EXIF block of a JPEG, PNG or WebP; empty if there is none.
std::string_view find_exif(std::string_view bytes, ImageFormat format) {
    constexpr std::uint32_t kApp1 = 0xE1;
    if (format == ImageFormat::Jpeg) {
        for (auto part = jpeg_segment(bytes, kJpegSegments); part && part->marker != kJpegScan;
             part = jpeg_segment(bytes, part->end)) {
            if (part->marker == kApp1 && part->data.starts_with("Exif\0"sv)) return part->data;
        }
    } else if (format == ImageFormat::Png) {
        for (auto chunk = png_chunk(bytes, kPngChunks); chunk; chunk = png_chunk(bytes, chunk->end)) {
            if (chunk->name == "eXIf") return chunk->data;
        }
    } else if (format == ImageFormat::WebP) {
        for (auto chunk = riff_chunk(bytes, kRiffChunks); chunk; chunk = riff_chunk(bytes, chunk->end)) {
            if (chunk->name == "EXIF") return chunk->data;
        }
    }
    return {};
}

}  // namespace

Result<ImageFormat> recognise_image(std::string_view bytes) {
    if (bytes.empty()) return failure(ErrorCode::Malformed, "there is no image: the request is empty");
    if (bytes.starts_with("\x89PNG\r\n\x1a\n"sv)) return ImageFormat::Png;
    if (bytes.starts_with("\xff\xd8\xff"sv)) return ImageFormat::Jpeg;
    if (bytes.starts_with("RIFF"sv) && bytes.substr(0, 12).ends_with("WEBP"sv)) return ImageFormat::WebP;
    for (const auto mark : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
        if (bytes.starts_with(mark)) return ImageFormat::Tiff;
    }
    if (bytes.starts_with("GIF87a"sv) || bytes.starts_with("GIF89a"sv)) return ImageFormat::Gif;
    if (is_bmp(bytes)) return ImageFormat::Bmp;
    if (is_avif(bytes)) return ImageFormat::Avif;
    if (is_heic(bytes)) return ImageFormat::Heic;
    const std::string_view kind = kind_of_file(bytes);
    return failure(ErrorCode::Unsupported, "this is " + std::string(kind.empty() ? "not a supported image" : kind) +
                                               std::string(kPictureFormats));
}

Result<ImageHeader> read_image_header(std::string_view bytes, std::size_t max_pixels) {
    const auto format = recognise_image(bytes);
    if (!format) return tl::unexpected(format.error());
    auto header = read(bytes, *format);
    if (!header) return header;
    if (header->width == 0 || header->height == 0) return broken_image();
    header->frames = std::max(count_frames(bytes, *format), uint64_t{1});
    if (header->width <= max_pixels / header->height) {
        header->decoder_bytes += kReaderBytes + header->width * kRowBytes;
        if (may_have_profile(bytes, *format)) header->decoder_bytes += kProfileBytes + bytes.size();
        return header;
    }
    return failure(ErrorCode::LimitExceeded,
                   "the image has " + std::to_string(header->width) + " x " + std::to_string(header->height) +
                       " pixels; this server's limit (max-pixels) is " + std::to_string(max_pixels));
}

std::string describe_frame(const ImageHeader& header) {
    if (header.frames == 1) return {};
    const bool stands_apart =
        header.format == ImageFormat::Png || header.format == ImageFormat::Avif || header.format == ImageFormat::Heic;
    return "the file has " + std::to_string(header.frames) +
           (header.format == ImageFormat::Tiff ? " pages" : " frames") + ": " +
           (stands_apart ? "the main picture" : "the first") + " is used";
}

int shown_orientation(std::string_view bytes, const ImageHeader& header) {
    const bool is_heif = header.format == ImageFormat::Avif || header.format == ImageFormat::Heic;
    if (is_heif) return header.view.orientation;
    if (header.format != ImageFormat::Tiff) return exif_orientation(bytes, header.format);
    return static_cast<int>(TiffDirectory(bytes).number(tiff::kOrientation).value_or(1));
}

int exif_orientation(std::string_view bytes, ImageFormat format) {
    std::string_view exif = find_exif(bytes, format);
    if (exif.starts_with("Exif")) exif.remove_prefix(std::min<std::size_t>(6, exif.size()));
    return static_cast<int>(TiffDirectory(exif).number(tiff::kOrientation).value_or(1));
}

}  // namespace ccdt::api
