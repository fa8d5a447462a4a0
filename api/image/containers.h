// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ccdt::api {

/// Reads unsigned integers from a file.
class ByteReader {
public:
    ByteReader(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}

    /// @param size  1 to 4 bytes
    /// @returns     none if the bytes are beyond the end of the file
    std::optional<std::uint32_t> read(std::size_t offset, std::size_t size) const;

    /// Reads 8 bytes.
    std::optional<std::uint64_t> read_long(std::size_t offset) const;

private:
    std::string_view bytes_;
    bool big_endian_;
};

/// A named part of a file.
struct Chunk {
    std::string_view name;
    std::string_view data;
    std::size_t begin = 0;  ///< offset of the chunk, including its header
    std::size_t end = 0;    ///< offset of the next chunk
};

inline constexpr std::size_t kPngChunks = 8;      ///< offset of the first chunk of a PNG file
inline constexpr std::size_t kRiffChunks = 12;    ///< offset of the first chunk of a WebP file
inline constexpr std::size_t kJpegSegments = 2;   ///< offset of the first segment of a JPEG file
inline constexpr std::uint32_t kJpegScan = 0xDA;  ///< marker of the header of a scan in a JPEG file
inline constexpr std::uint32_t kJpegEnd = 0xD9;   ///< marker of the end of a JPEG file

/// Returns the chunk of a PNG file at an offset; none if the file ends before the chunk does.
/// Source: PNG (ISO/IEC 15948), 5.3.
std::optional<Chunk> png_chunk(std::string_view bytes, std::size_t at);

/// Returns the suggested palette of a PNG file if it stands after the transparent colour. Because of this wrong order,
/// libpng would ignore the colour, which viewers do not.
std::optional<Chunk> misplaced_palette(std::string_view bytes);

/// Returns the chunk of a WebP file at an offset; none if the file ends before the chunk's data. The data of a
/// truncated chunk ends with the file.
/// Source: WebP (RFC 9649), 2.3.
std::optional<Chunk> riff_chunk(std::string_view bytes, std::size_t at);

/// Returns the box of an AVIF file at an offset, with its type as the name; none if the file ends before the box's
/// data, or if the box claims to be smaller than its header. The data of a truncated box ends with the file.
/// Source: ISO/IEC 14496-12, 4.2.
std::optional<Chunk> media_box(std::string_view bytes, std::size_t at);

/// A segment of a JPEG file, without the entropy-coded data that may follow.
struct Segment {
    std::uint32_t marker = 0;    ///< second byte of the marker
    std::string_view data = {};  ///< without the length; in a truncated segment, up to the end of the file
    std::size_t begin = 0;       ///< offset of the marker
    std::size_t end = 0;         ///< offset after the segment
};

/// Returns the segment at an offset. Skips all bytes before the marker, as decoders do. Returns none if there is no
/// marker, or if the segment has no valid length.
/// Source: JPEG (ITU-T T.81), B.1.1.
std::optional<Segment> jpeg_segment(std::string_view bytes, std::size_t at);

/// Process of coding that the frame of a JPEG uses.
enum class JpegCoding { Sequential, Progressive, Other };

/// Returns the process that a marker of a frame states; none for other markers.
/// Source: JPEG (ITU-T T.81), table B.1; JPEG-LS (ITU-T T.87), C.1.1.
std::optional<JpegCoding> jpeg_coding(std::uint32_t marker);

/// Returns the header of the first frame of a JPEG; none if a scan or the end of the file precedes it.
/// @param at  offset after the marker of the beginning of the JPEG
std::optional<Segment> jpeg_frame(std::string_view bytes, std::size_t at = kJpegSegments);

/// Returns the kind of a JPEG that the decoder does not read, as in "a JPEG with 12 bits per channel"; empty if it
/// reads this kind.
std::string unread_jpeg(const Segment& frame);

/// Returns a copy of a JPEG file without bytes between the segments before its first scan, with known values in these
/// segments, and with the marker of its end. Decoders only warn of such faults. Returns an empty string if the file has
/// none of them.
std::string repair_jpeg(std::string_view bytes);

/// Reads a directory of a TIFF or BigTIFF file, or of an EXIF block.
/// Source: TIFF 6.0, 2; the BigTIFF file format.
class TiffDirectory {
public:
    static constexpr std::uint32_t kWidth = 256, kHeight = 257;  ///< tags of the picture's size

    /// Reads the first directory.
    explicit TiffDirectory(std::string_view bytes);

    /// Reads the directory at an offset.
    TiffDirectory(std::string_view bytes, std::size_t begin);

    /// Returns an unsigned integer below 2^32 in the entry of a tag; none if there is no such entry or integer.
    std::optional<std::uint32_t> number(std::uint32_t tag, std::uint32_t index = 0) const;

    /// Returns the bytes in the entry of a tag; none if there is no entry, or if the file ends too early.
    std::optional<std::string_view> data(std::uint32_t tag) const;

    bool has(std::uint32_t tag) const { return find(tag).has_value(); }
    std::size_t entries() const { return entries_; }
    std::size_t begin() const { return begin_; }  ///< offset of the directory; 0: none
    std::size_t next() const;                     ///< offset of the next directory in the file's list; 0: none

private:
    std::size_t entry(std::size_t index) const;
    std::optional<std::size_t> find(std::uint32_t tag) const;
    std::optional<std::uint64_t> integer(std::size_t at, std::size_t size) const;

    std::string_view bytes_;
    ByteReader reader_;
    bool is_big_;       ///< whether the file is a BigTIFF
    std::size_t word_;  ///< size of counts and offsets in bytes
    std::size_t begin_ = 0;
    std::size_t entries_ = 0;
};

}  // namespace ccdt::api
