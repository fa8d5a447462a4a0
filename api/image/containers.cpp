// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/containers.h"

#include <algorithm>
#include <utility>

namespace ccdt::api {

std::optional<std::uint32_t> ByteReader::read(std::size_t offset, std::size_t size) const {
    if (offset > bytes_.size() || size > bytes_.size() - offset) return std::nullopt;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t at = offset + (big_endian_ ? i : size - 1 - i);
        value = value << 8 | static_cast<unsigned char>(bytes_[at]);
    }
    return value;
}

std::optional<std::uint64_t> ByteReader::read_long(std::size_t offset) const {
    const auto first = read(offset, 4), second = read(offset + 4, 4);
    if (!first || !second) return std::nullopt;
    const auto [high, low] = big_endian_ ? std::pair(*first, *second) : std::pair(*second, *first);
    return std::uint64_t{high} << 32 | low;
}

std::optional<Chunk> png_chunk(std::string_view bytes, std::size_t at) {
    constexpr std::size_t kHead = 8, kChecksum = 4;
    const auto length = ByteReader(bytes, true).read(at, 4);
    if (!length || at + kHead + *length + kChecksum > bytes.size()) return std::nullopt;
    return Chunk{bytes.substr(at + 4, 4), bytes.substr(at + kHead, *length), at, at + kHead + *length + kChecksum};
}

std::optional<Chunk> misplaced_palette(std::string_view bytes) {
    constexpr std::size_t kColourType = 25;
    constexpr std::uint32_t kTrueColour = 2;
    if (ByteReader(bytes, true).read(kColourType, 1) != kTrueColour) return std::nullopt;
    bool is_after = false;
    for (auto chunk = png_chunk(bytes, kPngChunks); chunk && chunk->name != "IDAT";
         chunk = png_chunk(bytes, chunk->end)) {
        if (chunk->name == "tRNS") is_after = true;
        if (chunk->name == "PLTE" && is_after) return chunk;
    }
    return std::nullopt;
}

std::optional<Chunk> riff_chunk(std::string_view bytes, std::size_t at) {
    constexpr std::size_t kHead = 8;
    const auto size = ByteReader(bytes, false).read(at + 4, 4);
    if (!size) return std::nullopt;
    return Chunk{bytes.substr(at, 4), bytes.substr(at + kHead, *size), at, at + kHead + *size + *size % 2};
}

std::optional<Chunk> media_box(std::string_view bytes, std::size_t at) {
    constexpr std::uint32_t kToTheEnd = 0, kLong = 1;
    const ByteReader reader(bytes, true);
    const auto size = reader.read(at, 4);
    if (!size || !reader.read(at + 4, 4)) return std::nullopt;
    std::size_t head = 8;
    std::uint64_t whole = *size;
    if (*size == kToTheEnd) whole = bytes.size() - at;
    if (*size == kLong) {
        head = 16;
        const auto longer = reader.read_long(at + 8);
        if (!longer) return std::nullopt;
        whole = *longer;
    }
    if (whole < head) return std::nullopt;
    const auto present = static_cast<std::size_t>(std::min<std::uint64_t>(whole, bytes.size() - at));
    return Chunk{bytes.substr(at + 4, 4), bytes.substr(at + head, present - head), at, at + present};
}

std::optional<Segment> jpeg_segment(std::string_view bytes, std::size_t at) {
    const ByteReader reader(bytes, true);
    auto mark = reader.read(at, 2);
    while (mark && (*mark >> 8 != 0xFF || *mark == 0xFF00 || *mark == 0xFFFF)) mark = reader.read(++at, 2);
    if (!mark) return std::nullopt;
    const std::uint32_t marker = *mark & 0xFF;
    const bool stands_alone = marker == 0x01 || (marker >= 0xD0 && marker <= 0xD9);
    if (stands_alone) return Segment{marker, {}, at, at + 2};
    auto length = reader.read(at + 2, 2);
    if (!length) return std::nullopt;
    length = std::max(*length, 2U);  // the length counts its own two bytes; decoders take 0 and 1 as empty
    return Segment{marker, bytes.substr(at + 4, *length - 2), at, at + 2 + *length};
}

std::optional<JpegCoding> jpeg_coding(std::uint32_t marker) {
    constexpr std::uint32_t kJpegLs = 0xF7;
    switch (marker) {
        case 0xC0:
        case 0xC1:
        case 0xC9:
            return JpegCoding::Sequential;
        case 0xC2:
        case 0xCA:
            return JpegCoding::Progressive;
        case 0xC4:
        case 0xC8:
        case 0xCC:
            return std::nullopt;
        default:
            break;
    }
    const bool is_frame = (marker >= 0xC0 && marker <= 0xCF) || marker == kJpegLs;
    return is_frame ? std::optional(JpegCoding::Other) : std::nullopt;
}

std::optional<Segment> jpeg_frame(std::string_view bytes, std::size_t at) {
    for (auto segment = jpeg_segment(bytes, at); segment; segment = jpeg_segment(bytes, segment->end)) {
        if (segment->marker == kJpegEnd || segment->marker == kJpegScan) break;
        if (jpeg_coding(segment->marker)) return segment;
    }
    return std::nullopt;
}

std::string unread_jpeg(const Segment& frame) {
    constexpr int kBits = 8;
    if (jpeg_coding(frame.marker) == JpegCoding::Other) return "a JPEG with lossless or hierarchical coding";
    if (ByteReader(frame.data, true).read(1, 2) == 0U) return "a JPEG that states its height after its rows (DNL)";
    const int bits = frame.data.empty() ? kBits : static_cast<unsigned char>(frame.data.front());
    return bits == kBits ? "" : "a JPEG with " + std::to_string(bits) + " bits per channel";
}

namespace {

/// Replaces unknown values in a JPEG, of which decoders only warn, by those that decoders assume: the version of JFIF,
/// the transform of Adobe, and the spectral range of a sequential scan.
/// @param head  the file up to the end of the first scan's header
/// @returns     whether there were such values
bool replace_unknown_values(std::string& head) {
    using namespace std::string_view_literals;
    bool is_changed = false;
    const auto set = [&](std::size_t at, char value) {
        is_changed = is_changed || head[at] != value;
        head[at] = value;
    };
    bool is_sequential = false;
    char channels = 0;
    std::size_t transform = 0;
    for (auto segment = jpeg_segment(head, kJpegSegments); segment; segment = jpeg_segment(head, segment->end)) {
        const auto& [marker, data, begin, end] = *segment;
        const std::size_t first = begin + 4;
        if (marker == 0xE0 && data.size() > 5 && data.starts_with("JFIF\0"sv)) set(first + 5, 1);
        if (marker == 0xEE && data.size() > 11 && data.starts_with("Adobe")) transform = first + 11;
        const auto coding = jpeg_coding(marker);
        is_sequential = is_sequential || coding == JpegCoding::Sequential;
        if (coding && data.size() > 5) channels = data[5];
        if (marker != kJpegScan || !is_sequential || data.size() < 3 || end > head.size()) continue;
        set(end - 3, 0);
        set(end - 2, 63);
        set(end - 1, 0);
    }
    if (transform != 0 && head[transform] != 0 && channels >= 3) set(transform, static_cast<char>(channels - 2));
    return is_changed;
}

}  // namespace

std::string repair_jpeg(std::string_view bytes) {
    constexpr std::string_view kEnd = "\xff\xd9";
    std::string repaired(bytes.substr(0, kJpegSegments));
    std::size_t at = kJpegSegments;
    bool is_broken = !bytes.ends_with(kEnd);
    for (auto segment = jpeg_segment(bytes, at); segment; segment = jpeg_segment(bytes, at)) {
        is_broken = is_broken || segment->begin != at;
        const std::string_view part = bytes.substr(segment->begin, segment->end - segment->begin);
        repaired += part;
        at = segment->begin + part.size();
        if (segment->marker == kJpegScan) break;
    }
    is_broken = replace_unknown_values(repaired) || is_broken;
    if (!is_broken) return {};
    repaired += bytes.substr(at);
    return repaired += kEnd;
}

TiffDirectory::TiffDirectory(std::string_view bytes) : TiffDirectory(bytes, 0) {
    *this = TiffDirectory(bytes, integer(is_big_ ? 8 : 4, word_).value_or(0));
}

TiffDirectory::TiffDirectory(std::string_view bytes, std::size_t begin)
    : bytes_(bytes),
      reader_(bytes, bytes.starts_with("MM")),
      is_big_(reader_.read(2, 2) == 43U),
      word_(is_big_ ? 8 : 4) {
    constexpr std::size_t kMax = 65'535;  // entries, as many as a classic TIFF can have
    const auto entries = integer(begin, is_big_ ? 8 : 2);
    if (begin == 0 || !entries || *entries > kMax) return;
    begin_ = begin;
    entries_ = *entries;
}

std::size_t TiffDirectory::next() const {
    if (begin_ == 0) return 0;
    return integer(entry(entries_), word_).value_or(0);
}

/// Returns the offset of an entry: a tag, a type, a count, and the value or its offset.
std::size_t TiffDirectory::entry(std::size_t index) const {
    return begin_ + (is_big_ ? 8 : 2) + (4 + 2 * word_) * index;
}

/// Reads an unsigned integer of 1, 2, 4 or 8 bytes.
std::optional<std::uint64_t> TiffDirectory::integer(std::size_t at, std::size_t size) const {
    if (size == 8) return reader_.read_long(at);
    return reader_.read(at, size);
}

std::optional<std::size_t> TiffDirectory::find(std::uint32_t tag) const {
    for (std::size_t i = 0; i < entries_; ++i) {
        const auto name = reader_.read(entry(i), 2);
        if (!name) return std::nullopt;
        if (*name == tag) return entry(i);
    }
    return std::nullopt;
}

std::optional<std::uint32_t> TiffDirectory::number(std::uint32_t tag, std::uint32_t index) const {
    constexpr std::uint32_t kShort = 3, kLong = 4, kLong8 = 16, kLargest = 0xFFFFFFFF;
    const auto entry = find(tag);
    if (!entry) return std::nullopt;
    const auto type = reader_.read(*entry + 2, 2);
    const std::size_t size = type == kShort ? 2 : type == kLong ? 4 : 8;
    if (size == 8 && type != kLong8) return std::nullopt;
    const auto count = integer(*entry + 4, word_);
    if (!count || index >= *count) return std::nullopt;
    const std::size_t position = *entry + 4 + word_;
    const auto values = *count <= word_ / size ? position : integer(position, word_);
    const auto value = values ? integer(*values + index * size, size) : std::nullopt;
    return value && *value <= kLargest ? std::optional(static_cast<std::uint32_t>(*value)) : std::nullopt;
}

std::optional<std::string_view> TiffDirectory::data(std::uint32_t tag) const {
    const auto entry = find(tag);
    if (!entry) return std::nullopt;
    const auto size = integer(*entry + 4, word_);
    const auto begin = integer(*entry + 4 + word_, word_);
    if (!size || !begin || *begin > bytes_.size() || *size > bytes_.size() - *begin) return std::nullopt;
    return bytes_.substr(*begin, *size);
}

}  // namespace ccdt::api
