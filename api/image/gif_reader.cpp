// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/gif_reader.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "api/image/broken_image.h"
#include "api/image/containers.h"

namespace ccdt::api {
namespace {

/// Reads the numbers of a file one after another. Past the end of the file, numbers are 0 and is_whole() is false.
class Cursor {
public:
    explicit Cursor(std::string_view bytes) : bytes_(bytes) {}

    bool is_whole() const { return whole_; }

    std::uint32_t next(std::size_t size) {
        const auto value = ByteReader(bytes_, false).read(at_, size);
        at_ += size;
        whole_ = whole_ && value;
        return value.value_or(0);
    }

    std::string_view take(std::size_t size) {
        whole_ = whole_ && at_ <= bytes_.size() && size <= bytes_.size() - at_;
        const auto taken = whole_ ? bytes_.substr(at_, size) : std::string_view();
        at_ += size;
        return taken;
    }

private:
    std::string_view bytes_;
    std::size_t at_ = 0;
    bool whole_ = true;
};

/// Reads codes of a few bits, lowest bit first. The codes are stored in blocks. Each block begins with its length, and
/// the last block is empty.
class CodeReader {
public:
    explicit CodeReader(Cursor& file) : file_(file) {}

    /// @returns  none past the end
    std::optional<unsigned> next(int size) {
        while (count_ < size) {
            if (left_ == 0) left_ = file_.next(1);
            if (left_ == 0) return std::nullopt;
            bits_ |= file_.next(1) << count_;
            if (!file_.is_whole()) return std::nullopt;
            count_ += 8;
            --left_;
        }
        const unsigned code = bits_ & ((1U << size) - 1);
        bits_ >>= size;
        count_ -= size;
        return code;
    }

private:
    Cursor& file_;
    std::uint32_t left_ = 0;  ///< bytes left in the block
    std::uint32_t bits_ = 0;  ///< bits that have been read but not used, in the low end
    int count_ = 0;
};

/// Table of the strings of pixels that codes represent. Each string is an earlier string plus one pixel.
class Strings {
public:
    static constexpr unsigned kMax = 4096;

    explicit Strings(unsigned clear) : clear_(clear) {
        for (unsigned i = 0; i < clear; ++i) strings_[i] = {0, static_cast<std::uint8_t>(i), 1};
        forget();
    }

    void forget() { count_ = clear_ + 2; }
    unsigned count() const { return count_; }
    std::size_t length(unsigned code) const { return strings_[code].length; }

    std::uint8_t first(unsigned code) const {
        while (strings_[code].length > 1) code = strings_[code].earlier;
        return strings_[code].last;
    }

    void add(unsigned earlier, std::uint8_t last) {
        if (count_ == kMax) return;
        strings_[count_++] = {static_cast<std::uint16_t>(earlier), last,
                              static_cast<std::uint16_t>(strings_[earlier].length + 1)};
    }

    /// Writes as much of a string as fits, from its beginning.
    void write(unsigned code, std::span<std::uint8_t> to) const {
        for (std::size_t i = strings_[code].length; i-- > 0; code = strings_[code].earlier) {
            if (i < to.size()) to[i] = strings_[code].last;
        }
    }

private:
    struct String {
        std::uint16_t earlier = 0;
        std::uint8_t last = 0;
        std::uint16_t length = 0;
    };

    unsigned clear_;
    unsigned count_ = 0;
    std::array<String, kMax> strings_{};
};

/// Decodes all pixels. Returns false if the data is invalid or too short.
bool decode_lzw(Cursor& file, std::span<std::uint8_t> pixels) {
    constexpr int kLongest = 12;
    constexpr unsigned kNone = Strings::kMax;
    const auto depth = static_cast<int>(file.next(1));
    if (depth < 2 || depth > 8) return false;
    const unsigned clear = 1U << depth;
    Strings strings(clear);
    CodeReader codes(file);
    int size = depth + 1;
    unsigned previous = kNone;
    for (std::size_t filled = 0; filled < pixels.size();) {
        const auto code = codes.next(size);
        if (!code || *code == clear + 1) return false;
        if (*code == clear) {
            strings.forget();
            size = depth + 1;
            previous = kNone;
            continue;
        }
        const bool is_new = previous != kNone && *code == strings.count();
        if (*code >= strings.count() && !is_new) return false;
        if (previous != kNone) strings.add(previous, strings.first(is_new ? previous : *code));
        const auto free_part = pixels.subspan(filled);
        strings.write(*code, free_part);
        filled += std::min(strings.length(*code), free_part.size());
        if (strings.count() == 1U << size && size < kLongest) ++size;
        previous = *code;
    }
    return true;
}

void skip_blocks(Cursor& file) {
    while (const auto size = file.next(1)) file.take(size);
}

struct Rectangle {
    int left = 0;
    int top = 0;
    int width = 0;
    int height = 0;
};

struct Frame {
    Rectangle place;
    bool interlaced = false;
    std::string_view palette;  ///< three bytes per colour
    std::optional<std::uint8_t> transparent;
    std::vector<std::uint8_t> pixels;

    /// Returns the index of a row among the stored rows.
    int stored_row(int y) const {
        if (!interlaced) return y;
        const int eighths = (place.height + 7) / 8, fourths = (place.height + 3) / 8, halves = (place.height + 1) / 4;
        if (y % 8 == 0) return y / 8;
        if (y % 8 == 4) return eighths + y / 8;
        if (y % 4 == 2) return eighths + fourths + y / 4;
        return eighths + fourths + halves + y / 2;
    }
};

std::string_view read_palette(Cursor& file, std::uint32_t flags) {
    return (flags & 0x80) != 0 ? file.take(std::size_t{3} * (2U << (flags & 7))) : std::string_view();
}

/// Reads a frame. The byte that introduces the frame has already been read.
bool read_frame(Cursor& file, int width, int height, Frame& frame) {
    const auto number = [&] { return static_cast<int>(file.next(2)); };
    Rectangle& place = frame.place;
    place.left = number();
    place.top = number();
    place.width = number();
    place.height = number();
    const auto flags = file.next(1);
    frame.interlaced = (flags & 0x40) != 0;
    if (const auto own = read_palette(file, flags); !own.empty()) frame.palette = own;
    const bool fits =
        place.width > 0 && place.height > 0 && place.left + place.width <= width && place.top + place.height <= height;
    if (!fits || frame.palette.empty() || !file.is_whole()) return false;
    frame.pixels.resize(static_cast<std::size_t>(place.width) * static_cast<std::size_t>(place.height));
    return decode_lzw(file, frame.pixels);
}

/// Reads the control block that describes how to show the next frame.
void read_control(Cursor& file, Frame& frame) {
    const auto size = file.next(1);
    const ByteReader control(file.take(size), false);
    const auto flags = control.read(0, 1).value_or(0);
    const auto index = control.read(3, 1);
    frame.transparent.reset();
    if ((flags & 1) != 0 && index) frame.transparent = static_cast<std::uint8_t>(*index);
    if (size > 0) skip_blocks(file);
}

/// Finds the first frame, and reads the frame and the control block before it.
bool find_frame(Cursor& file, int width, int height, Frame& frame) {
    constexpr std::uint32_t kExtension = 0x21, kFrame = 0x2C, kControl = 0xF9;
    while (file.is_whole()) {
        const auto mark = file.next(1);
        if (mark == kFrame) return read_frame(file, width, height, frame);
        if (mark != kExtension) return false;
        if (file.next(1) == kControl) {
            read_control(file, frame);
        } else {
            skip_blocks(file);
        }
    }
    return false;
}

/// Writes a row of the picture: red, green and blue, and alpha if there are four channels.
void write_row(const Frame& frame, int y, int width, std::size_t channels, std::uint8_t* to) {
    const Rectangle& place = frame.place;
    std::fill_n(to, static_cast<std::size_t>(width) * channels, std::uint8_t{0});
    if (y < place.top || y >= place.top + place.height) return;
    const std::size_t row = static_cast<std::size_t>(frame.stored_row(y - place.top));
    const std::uint8_t* const pixels = &frame.pixels[row * static_cast<std::size_t>(place.width)];
    to += static_cast<std::size_t>(place.left) * channels;
    for (int i = 0; i < place.width; ++i, to += channels) {
        const std::size_t colour = std::size_t{3} * pixels[i];
        if (pixels[i] == frame.transparent) continue;
        // A colour that is missing from the palette is black.
        for (std::size_t j = 0; j < 3 && colour + 3 <= frame.palette.size(); ++j)
            to[j] = static_cast<std::uint8_t>(frame.palette[colour + j]);
        if (channels == 4) to[3] = 255;
    }
}

}  // namespace

Result<RowSource> open_gif(std::string_view bytes) {
    constexpr std::size_t kSignature = 6;
    Cursor file(bytes);
    file.take(kSignature);
    RowSource source;
    source.width = static_cast<int>(file.next(2));
    source.height = static_cast<int>(file.next(2));
    const auto flags = file.next(1);
    file.take(2);  // skips the background colour, which viewers ignore, and the pixel aspect ratio
    const auto frame = std::make_shared<Frame>();
    frame->palette = read_palette(file, flags);
    if (!find_frame(file, source.width, source.height, *frame)) return broken_image();

    const bool covers = frame->place.width == source.width && frame->place.height == source.height;
    source.channels = covers && !frame->transparent ? 3 : 4;
    source.alpha = source.channels == 4 ? 3 : -1;
    source.read = [frame, width = source.width, channels = static_cast<std::size_t>(source.channels)](
                      int begin, int end, void* rows) {
        auto* to = static_cast<std::uint8_t*>(rows);
        for (int y = begin; y < end; ++y, to += static_cast<std::size_t>(width) * channels)
            write_row(*frame, y, width, channels, to);
        return true;
    };
    return source;
}

}  // namespace ccdt::api
