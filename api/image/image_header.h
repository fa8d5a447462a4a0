#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/result.h"

namespace ccdt::api {

enum class ImageFormat { Png, Jpeg, WebP, Tiff, Gif, Bmp, Avif };

/// Header of an image file: what it says of itself before its pixels. Told without the image library, whose readers are
/// better kept away from files that nobody has looked at.
struct ImageHeader {
    ImageFormat format = ImageFormat::Png;
    std::uint64_t width = 0;   ///< >= 1, as stored: not turned upright
    std::uint64_t height = 0;  ///< >= 1
    /// Bytes a reader takes at most while it decodes the picture, besides the file and the planes that it makes.
    std::uint64_t decoder_bytes = 0;
    bool is_ink_jpeg = false;  ///< of four channels: cyan, magenta, yellow, black
    std::uint64_t frames = 1;  ///< that the file holds, of a TIFF pages; one of them is read

    std::uint64_t pixels() const { return width * height; }
};

/// Image file whose header was read.
struct ImageFile {
    std::string_view bytes;  ///< of whoever gave it, who must outlive this, or of `decoded`
    ImageHeader header;
    std::shared_ptr<const std::string> decoded = {};  ///< from a text that held the file; null: it came as it is
};

/// Most pixels in all by which the tiles of a TIFF may stand over its border.
inline constexpr std::uint64_t kMostTilePixels = std::uint64_t{1} << 20;

/// Longest side of an AVIF, as its codec has it.
inline constexpr std::uint64_t kMostAvifSide = 65'536;

/// Tells by its first bytes whether an image file is of a format that is read: PNG, JPEG, WebP, TIFF, GIF, BMP or
/// AVIF.
/// Errors: Malformed if there are no bytes; Unsupported for any other format, naming it if it is known, and those that
/// are read.
Result<ImageFormat> recognise_image(std::string_view bytes);

/// Reads the header of the file's first picture.
///
/// Errors: those of recognise_image; Unusable for a header that is broken or cut short, for a TIFF that leaves out its
/// bits per sample, and for a JPEG of more than 100 scans; LimitExceeded for more pixels than the limit.
/// Sources: PNG (ISO/IEC 15948), 5 and 11.2.2; JPEG (ITU-T T.81), B.1 and B.2.2; WebP (RFC 9649), 2; TIFF 6.0, 2;
/// GIF89a, 18; Microsoft's BITMAPINFOHEADER; HEIF (ISO/IEC 23008-12), 6.5.3 and 6.5.6.
Result<ImageHeader> read_image_header(std::string_view bytes, std::size_t max_pixels);

/// Tells which of several frames or pages is read; empty if there is but one.
std::string describe_frame(const ImageHeader& header);

/// Reads the orientation that a WebP file's EXIF block gives, 1 to 8; 1 if it gives none.
int webp_orientation(std::string_view bytes);

}  // namespace ccdt::api
