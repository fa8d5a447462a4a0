// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "api/image/heif_properties.h"
#include "api/image/image_format.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Properties of an image file that are stored before its pixels. They are read without the image library, because its
/// readers are not safe with unchecked files.
struct ImageHeader {
    ImageFormat format = ImageFormat::Png;
    std::uint64_t width = 0;   ///< >= 1; as stored, before the orientation is applied
    std::uint64_t height = 0;  ///< >= 1
    /// Peak memory in bytes that a reader needs to decode the picture, in addition to the file and the resulting
    /// planes.
    std::uint64_t decoder_bytes = 0;
    bool is_ink_jpeg = false;  ///< whether the file is a JPEG with four channels: cyan, magenta, yellow, black
    std::uint64_t frames = 1;  ///< number of frames, or of pages of a TIFF; only one of them is read
    HeifView view = {};        ///< of an AVIF or a HEIC

    std::uint64_t pixels() const { return width * height; }
};

/// An image file whose header was read.
struct ImageFile {
    std::string_view bytes;  ///< the file; lies in `decoded` or in the caller's memory, which must outlive this object
    ImageHeader header;
    std::shared_ptr<const std::string> decoded = {};  ///< owns the file if it was decoded from base64; otherwise null
};

/// Maximum number of samples of a pixel in a TIFF.
inline constexpr std::uint32_t kMaxTiffSamples = 16;

/// Maximum number of pixels that a tile of a TIFF may have in addition to the number of pixels of the picture.
inline constexpr std::uint64_t kMaxTilePixels = std::uint64_t{1} << 20;

/// Longest side of an AVIF that its codec allows.
inline constexpr std::uint64_t kMaxAvifSide = 65'536;

/// Longest side of a HEIC that libheif allows.
inline constexpr std::uint64_t kMaxHeicSide = 32'768;

/// End of messages about files that are not pictures.
inline constexpr std::string_view kPictureFormats =
    "; the supported formats are PNG, JPEG, WebP, TIFF, GIF, BMP, AVIF and HEIC";

/// Recognises the format of an image file by its first bytes: PNG, JPEG, WebP, TIFF, GIF, BMP, AVIF or HEIC.
/// Errors: Malformed if there are no bytes; Unsupported for any other format. The message names the format, if it is
/// known, and the supported formats.
Result<ImageFormat> recognise_image(std::string_view bytes);

/// Reads the header of the first picture in a file.
///
/// Errors: the errors of recognise_image(); Unusable for a broken or truncated header, for a JPEG with more than 100
/// scans, and for a HEIF without a still picture in HEVC; LimitExceeded for more than max_pixels pixels.
/// Sources: PNG (ISO/IEC 15948), 5 and 11.2.2; JPEG (ITU-T T.81), B.1 and B.2.2; WebP (RFC 9649), 2; TIFF 6.0, 2;
/// GIF89a, 18; Microsoft's BITMAPINFOHEADER; HEIF (ISO/IEC 23008-12), 6.5.3 and 6.5.6.
Result<ImageHeader> read_image_header(std::string_view bytes, std::size_t max_pixels);

/// Describes which frame or page is read, if there are several; empty otherwise.
std::string describe_frame(const ImageHeader& header);

/// Returns the orientation in the first EXIF block of a JPEG (a segment APP1), PNG (the chunk eXIf, also after the
/// picture data) or WebP (the chunk EXIF), 1 to 8; 1 if there is none. Texts that contain EXIF are ignored.
int exif_orientation(std::string_view bytes, ImageFormat format);

/// Returns the orientation in which a picture is shown: that of EXIF, of the first page of a TIFF, or of the properties
/// of a HEIF. From 5 to 8, width and height are exchanged; unknown values are upright.
int shown_orientation(std::string_view bytes, const ImageHeader& header);

}  // namespace ccdt::api
