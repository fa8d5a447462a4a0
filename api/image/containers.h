#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace ccdt::api {

/// Reader of unsigned integers inside a file.
class ByteReader {
public:
    ByteReader(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}

    /// @param size  1 to 4 bytes
    /// @returns     none past the end
    std::optional<std::uint32_t> read(std::size_t offset, std::size_t size) const;

private:
    std::string_view bytes_;
    bool big_endian_;
};

/// Named piece of a file.
struct Chunk {
    std::string_view name;
    std::string_view data;
    std::size_t begin = 0;  ///< of all that belongs to it
    std::size_t end = 0;    ///< where the next begins
};

inline constexpr std::size_t kPngChunks = 8;    ///< where the first chunk of a PNG file stands
inline constexpr std::size_t kRiffChunks = 12;  ///< where the first chunk of a WebP file stands
inline constexpr std::size_t kJpegSegments = 2;

/// Finds the chunk that stands there; none if the file ends before the chunk does.
/// Source: PNG (ISO/IEC 15948), 5.3.
std::optional<Chunk> png_chunk(std::string_view bytes, std::size_t at);

/// Finds the chunk that stands there; none past the end. Its data ends where the file does.
/// Source: WebP (RFC 9649), 2.3.
std::optional<Chunk> riff_chunk(std::string_view bytes, std::size_t at);

/// Finds the box that stands there, its name and what it holds; none past the end, nor where a box says that it is
/// smaller than its own head. Its data ends where the file does.
/// Source: ISO/IEC 14496-12, 4.2.
std::optional<Chunk> media_box(std::string_view bytes, std::size_t at);

/// Piece of a JPEG file before its entropy-coded data.
struct Segment {
    std::uint32_t marker = 0;    ///< its second byte
    std::string_view data = {};  ///< without the length; ends where the file does
    std::size_t end = 0;
};

/// Finds the segment that stands there, behind bytes that only fill; none where there is no marker.
/// Source: JPEG (ITU-T T.81), B.1.1.
std::optional<Segment> jpeg_segment(std::string_view bytes, std::size_t at);

/// Reader of the first directory of a TIFF file or EXIF block.
/// Source: TIFF 6.0, 2.
class TiffDirectory {
public:
    static constexpr std::size_t kEntrySize = 12;

    explicit TiffDirectory(std::string_view bytes);

    /// Reads the first of an entry's numbers, of 16 or 32 bits.
    std::optional<std::uint32_t> number(std::uint32_t tag) const;

    /// Finds an entry's bytes, whatever it says that they are; none if the file ends before they do.
    std::optional<std::string_view> data(std::uint32_t tag) const;

    bool has(std::uint32_t tag) const { return find(tag).has_value(); }
    std::size_t begin() const { return begin_; }      ///< where its number of entries stands
    std::size_t entries() const { return entries_; }  ///< as many as it says
    const ByteReader& reader() const { return reader_; }

private:
    std::optional<std::size_t> find(std::uint32_t tag) const;

    std::string_view bytes_;
    ByteReader reader_;
    std::size_t begin_ = 0;
    std::size_t entries_ = 0;
};

}  // namespace ccdt::api
