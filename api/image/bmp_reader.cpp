// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/bmp_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/image/broken_image.h"
#include "api/image/containers.h"

namespace ccdt::api {
namespace {

enum Compression : std::uint32_t { kNone = 0, kRuns8 = 1, kRuns4 = 2, kFields = 3, kAlphaFields = 6 };

struct Layout {
    static constexpr std::size_t kFileHeader = 14;
    static constexpr std::uint32_t kCore = 12, kShortOs2 = 16, kInfo = 40,
                                   kWithAlphaMask = 56;  ///< header sizes in bytes

    std::uint32_t header = 0;  ///< size of the header, in bytes
    std::size_t width = 0;
    std::size_t height = 0;
    bool from_top = false;
    std::uint32_t bits = 0;  ///< per pixel
    std::uint32_t compression = kNone;
    std::uint32_t colours = 0;  ///< number of colours in the palette; 0: 2^bits
    std::size_t begin = 0;      ///< offset of the pixels

    std::size_t row_size() const { return (width * bits + 31) / 32 * 4; }
    /// Returns the size of all rows. The last one need not be padded.
    std::size_t size() const { return (height - 1) * row_size() + (width * bits + 7) / 8; }
    bool has_runs() const { return compression == kRuns8 || compression == kRuns4; }
    bool has_palette() const { return bits <= 8; }
};

std::optional<Layout> read_layout(std::string_view bytes) {
    const ByteReader reader(bytes, false);
    Layout layout;
    layout.begin = reader.read(10, 4).value_or(0);
    layout.header = reader.read(Layout::kFileHeader, 4).value_or(0);
    if (layout.header == Layout::kCore) {
        layout.width = reader.read(18, 2).value_or(0);
        layout.height = reader.read(20, 2).value_or(0);
        layout.bits = reader.read(24, 2).value_or(0);
    } else {
        const auto height = static_cast<std::int32_t>(reader.read(22, 4).value_or(0));
        layout.width = reader.read(18, 4).value_or(0);
        layout.height = static_cast<std::size_t>(height < 0 ? -std::int64_t{height} : height);
        layout.from_top = height < 0;
        layout.bits = reader.read(28, 2).value_or(0);
        if (layout.header != Layout::kShortOs2) {
            layout.compression = reader.read(30, 4).value_or(0);
            layout.colours = reader.read(46, 4).value_or(0);
        }
    }
    constexpr std::uint32_t kMaxSide = 1U << 30;
    if (layout.width < 1 || layout.height < 1 || layout.width > kMaxSide || layout.height > kMaxSide)
        return std::nullopt;
    return layout;
}

bool is_known(const Layout& layout) {
    switch (layout.compression) {
        case kNone:
            return layout.bits == 1 || layout.bits == 2 || layout.bits == 4 || layout.bits == 8 || layout.bits == 16 ||
                   layout.bits == 24 || layout.bits == 32;
        case kRuns8:
            return layout.bits == 8;
        case kRuns4:
            return layout.bits == 4;
        case kFields:
        case kAlphaFields:
            return layout.bits == 16 || layout.bits == 32;
        default:
            return false;
    }
}

using Colour = std::array<std::uint8_t, 3>;

/// Reads the palette. Colours that are missing from the file are black.
std::array<Colour, 256> read_palette(std::string_view bytes, const Layout& layout) {
    std::array<Colour, 256> palette{};
    const std::size_t size = layout.header == Layout::kCore ? 3 : 4;
    const std::size_t all = std::size_t{1} << layout.bits;
    const std::size_t count = layout.colours == 0 ? all : std::min<std::size_t>(all, layout.colours);
    const ByteReader reader(bytes, false);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t at = Layout::kFileHeader + layout.header + i * size;
        for (std::size_t j = 0; j < 3; ++j)
            palette[i][j] = static_cast<std::uint8_t>(reader.read(at + 2 - j, 1).value_or(0));
    }
    return palette;
}

/// Bits of a pixel that hold one of its channels.
struct Field {
    std::uint32_t mask = 0;
    int shift = 0;
    std::uint32_t most = 0;

    explicit Field(std::uint32_t bits = 0)
        : mask(bits), shift(bits == 0 ? 0 : std::countr_zero(bits)), most(bits >> shift) {}

    std::uint16_t of(std::uint32_t pixel) const {
        constexpr std::uint64_t kFull = 65535;
        const std::uint64_t value = (pixel & mask) >> shift;
        if (most == 255) return static_cast<std::uint16_t>(value * 257);
        return most == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>((value * kFull + most / 2) / most);
    }
};

/// Reads the fields of red, green, blue and alpha. Without compression, only the field of alpha is in the header.
std::array<Field, 4> read_fields(std::string_view bytes, const Layout& layout) {
    const ByteReader reader(bytes, false);
    const auto field = [&](std::size_t i) {
        return Field(reader.read(Layout::kFileHeader + Layout::kInfo + 4 * i, 4).value_or(0));
    };
    const bool has_alpha = (layout.bits == 16 || layout.bits == 32) &&
                           (layout.header >= Layout::kWithAlphaMask || layout.compression == kAlphaFields);
    const Field alpha = has_alpha ? field(3) : Field();
    if (layout.compression != kNone) return {field(0), field(1), field(2), alpha};
    if (layout.bits == 16) return {Field(0x7C00), Field(0x03E0), Field(0x001F), alpha};
    return {Field(0xFF0000), Field(0x00FF00), Field(0x0000FF), alpha};
}

/// Decoder of run-length encoded pixels, which are palette indices, row by row from the bottom.
class Runs {
public:
    Runs(std::string_view bytes, const Layout& layout)
        : layout_(layout), reader_(bytes, false), at_(layout.begin), indices_(layout.width * layout.height) {}

    /// @returns  false if the file ends before the last pixel; the marks of the end are not necessary
    bool unpack() {
        while (y_ < layout_.height) {
            const auto count = next();
            const auto value = next();
            if (!count || !value) return y_ + 1 == layout_.height && x_ >= layout_.width;
            if (*count > 0) {
                for (std::uint32_t i = 0; i < *count; ++i) put(index_in(*value, i));
            } else if (*value == 0) {
                x_ = 0;
                ++y_;
            } else if (*value == 1) {
                break;
            } else if (!(*value == 2 ? move() : copy(*value))) {
                return false;
            }
        }
        return true;
    }

    std::vector<std::uint8_t> take() { return std::move(indices_); }

private:
    std::optional<std::uint32_t> next() { return reader_.read(at_++, 1); }

    /// Returns the index of pixel i of a run. A byte contains two four-bit indices.
    std::uint8_t index_in(std::uint32_t byte, std::uint32_t i) const {
        if (layout_.bits == 8) return static_cast<std::uint8_t>(byte);
        return static_cast<std::uint8_t>(i % 2 == 0 ? byte >> 4 : byte & 15);
    }

    void put(std::uint8_t index) {
        if (x_ < layout_.width) indices_[y_ * layout_.width + x_++] = index;
    }

    bool move() {
        const auto right = next();
        const auto up = next();
        if (!right || !up) return false;
        x_ += *right;
        y_ += *up;
        return true;
    }

    bool copy(std::uint32_t count) {
        const std::uint32_t in_byte = 8 / layout_.bits;
        std::optional<std::uint32_t> byte;
        std::size_t bytes = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            if (i % in_byte == 0) {
                byte = next();
                ++bytes;
            }
            if (!byte) return false;
            put(index_in(*byte, i));
        }
        at_ += bytes % 2;
        return true;
    }

    const Layout& layout_;
    ByteReader reader_;
    std::size_t at_;
    std::size_t x_ = 0;
    std::size_t y_ = 0;
    std::vector<std::uint8_t> indices_;
};

/// Pixels of the file.
class Pixels {
public:
    Pixels(std::string_view bytes, Layout layout)
        : bytes_(bytes), layout_(layout), palette_(), fields_(read_fields(bytes, layout)) {
        if (layout.has_palette()) palette_ = read_palette(bytes, layout);
    }

    /// @returns  false if the file ends too early
    bool open() {
        if (layout_.has_runs()) {
            Runs runs(bytes_, layout_);
            if (!runs.unpack()) return false;
            indices_ = runs.take();
            return true;
        }
        const std::size_t left = layout_.begin <= bytes_.size() ? bytes_.size() - layout_.begin : 0;
        if (layout_.size() > left) return false;
        has_alpha_ = fields_[3].mask != 0 && any_alpha();
        return true;
    }

    bool has_alpha() const { return has_alpha_; }

    void write_colours(std::size_t y, std::uint8_t* to) const {
        for (std::size_t x = 0; x < layout_.width; ++x) to = std::ranges::copy(palette_[index(x, y)], to).out;
    }

    void write_fields(std::size_t y, std::uint16_t* to) const {
        for (std::size_t x = 0; x < layout_.width; ++x) {
            const std::uint32_t value = pixel(x, y);
            for (std::size_t i = 0; i < (has_alpha_ ? 4U : 3U); ++i) *to++ = fields_[i].of(value);
        }
    }

private:
    std::size_t stored_row(std::size_t y) const { return layout_.from_top ? y : layout_.height - 1 - y; }

    std::size_t byte(std::size_t at) const { return static_cast<unsigned char>(bytes_[at]); }

    std::size_t index(std::size_t x, std::size_t y) const {
        if (layout_.has_runs()) return indices_[stored_row(y) * layout_.width + x];
        const std::size_t bit = x * layout_.bits;
        const std::size_t value = byte(layout_.begin + stored_row(y) * layout_.row_size() + bit / 8);
        return value >> (8 - layout_.bits - bit % 8) & ((std::size_t{1} << layout_.bits) - 1);
    }

    std::uint32_t pixel(std::size_t x, std::size_t y) const {
        const std::size_t size = layout_.bits / 8;
        const std::size_t at = layout_.begin + stored_row(y) * layout_.row_size() + x * size;
        std::size_t value = 0;
        for (std::size_t i = size; i-- > 0;) value = value << 8 | byte(at + i);
        return static_cast<std::uint32_t>(value);
    }

    bool any_alpha() const {
        for (std::size_t y = 0; y < layout_.height; ++y) {
            for (std::size_t x = 0; x < layout_.width; ++x) {
                if ((pixel(x, y) & fields_[3].mask) != 0) return true;
            }
        }
        return false;
    }

    std::string_view bytes_;
    Layout layout_;
    std::array<Colour, 256> palette_;
    std::array<Field, 4> fields_;
    /// Decoded palette indices of a run-length encoded file; empty for other files.
    std::vector<std::uint8_t> indices_;
    bool has_alpha_ = false;
};

}  // namespace

Result<RowSource> open_bmp(std::string_view bytes) {
    const auto layout = read_layout(bytes);
    if (!layout) return broken_image();
    if (!is_known(*layout)) {
        return failure(ErrorCode::Unusable,
                       "there is no support for this kind of image: a BMP with " + std::to_string(layout->bits) +
                           " bits per pixel and compression method " + std::to_string(layout->compression));
    }
    const auto pixels = std::make_shared<Pixels>(bytes, *layout);
    if (!pixels->open()) return broken_image();
    RowSource source;
    source.width = static_cast<int>(layout->width);
    source.height = static_cast<int>(layout->height);
    source.channels = pixels->has_alpha() ? 4 : 3;
    source.alpha = pixels->has_alpha() ? 3 : -1;
    source.sample = layout->has_palette() ? RowSource::Sample::Byte : RowSource::Sample::Word;
    source.read = [pixels, has_palette = layout->has_palette(),
                   size = layout->width * static_cast<std::size_t>(source.channels)](int begin, int end, void* rows) {
        for (auto y = static_cast<std::size_t>(begin); y < static_cast<std::size_t>(end); ++y) {
            const std::size_t at = (y - static_cast<std::size_t>(begin)) * size;
            if (has_palette) {
                pixels->write_colours(y, static_cast<std::uint8_t*>(rows) + at);
            } else {
                pixels->write_fields(y, static_cast<std::uint16_t*>(rows) + at);
            }
        }
        return true;
    };
    return source;
}

}  // namespace ccdt::api
