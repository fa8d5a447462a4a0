// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/tiff_pixels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

namespace ccdt::api {
namespace {

using Sample = RowSource::Sample;
using Space = TiffPixels::Space;
using Type = TiffPixels::Type;

constexpr std::uint64_t kFullWord = std::numeric_limits<std::uint16_t>::max();

/// Rescales an integer of some bits to 16 bits.
std::uint16_t to_word(std::uint64_t code, int bits) {
    const std::uint64_t full = (std::uint64_t{1} << bits) - 1;
    return static_cast<std::uint16_t>((code * kFullWord + full / 2) / full);
}

/// Decodes a float of 16 or 24 bits. Source: DNG 1.7.1, "Floating Point Image Data".
float decode_float(std::uint64_t code, int exponent_bits, int mantissa_bits) {
    const auto mantissa = static_cast<int>(code & ((1U << mantissa_bits) - 1));
    const auto exponent = static_cast<int>(code >> mantissa_bits & ((1U << exponent_bits) - 1));
    const bool is_negative = (code >> (mantissa_bits + exponent_bits) & 1) != 0;
    const int bias = (1 << (exponent_bits - 1)) - 1;
    float value = 0;
    if (exponent == (1 << exponent_bits) - 1) {
        value = mantissa == 0 ? std::numeric_limits<float>::infinity() : std::numeric_limits<float>::quiet_NaN();
    } else if (exponent == 0) {
        value = std::ldexp(static_cast<float>(mantissa), 1 - bias - mantissa_bits);
    } else {
        value = std::ldexp(static_cast<float>(mantissa + (1 << mantissa_bits)), exponent - bias - mantissa_bits);
    }
    return is_negative ? -value : value;
}

float decode_float(std::uint64_t code, int bits) {
    switch (bits) {
        case 16:
            return decode_float(code, 5, 10);
        case 24:
            return decode_float(code, 7, 16);
        case 32:
            return std::bit_cast<float>(static_cast<std::uint32_t>(code));
        default: {
            constexpr double kLargest = std::numeric_limits<float>::max();
            const auto value = std::bit_cast<double>(code);
            return std::isfinite(value) ? static_cast<float>(std::clamp(value, -kLargest, kLargest))
                                        : std::numeric_limits<float>::quiet_NaN();
        }
    }
}

std::int64_t with_sign(std::uint64_t code, int bits) {
    const int spare = 64 - bits;
    return static_cast<std::int64_t>(code << spare) >> spare;
}

/// Reads unsigned integers: whole bytes in the machine's order, other sizes from the highest bit to the lowest.
class Codes {
public:
    Codes(const std::uint8_t* from, int bits) : from_(from), bits_(bits) {}

    std::uint64_t next() {
        if (bits_ == 8) return *from_++;
        if (bits_ > 8 && bits_ % 8 == 0) return next_word();
        while (held_ < bits_) {
            buffer_ = buffer_ << 8 | *from_++;
            held_ += 8;
        }
        held_ -= bits_;
        return buffer_ >> held_ & ((std::uint64_t{1} << bits_) - 1);
    }

private:
    std::uint64_t next_word() {
        const auto size = static_cast<std::size_t>(bits_ / 8);
        std::uint64_t code = 0;
        auto* const bytes = reinterpret_cast<std::uint8_t*>(&code);
        std::memcpy(std::endian::native == std::endian::little ? bytes : bytes + sizeof(code) - size, from_, size);
        from_ += size;
        return code;
    }

    const std::uint8_t* from_;
    int bits_;
    std::uint64_t buffer_ = 0;
    int held_ = 0;  ///< number of lowest bits in the buffer that are not returned yet
};

/// Returns the type of the samples before the conversion of colours. Indices into a palette are words.
Sample sample_of(const TiffPixels& pixels, TiffUse use) {
    if (pixels.space == Space::Palette) return Sample::Word;
    if (pixels.type == Type::Unsigned && pixels.bits == 8) return Sample::Byte;
    const bool keeps_values = use == TiffUse::Values && pixels.bits != 16;
    return pixels.type == Type::Unsigned && !keeps_values ? Sample::Word : Sample::Float;
}

bool is_lab(const TiffPixels& pixels) {
    return pixels.space == Space::CieLab || pixels.space == Space::IccLab;
}

/// Converts rows whose samples are of one type.
template <class Value>
class Converter {
public:
    Converter(TiffPixels pixels, TiffUse use)
        : pixels_(std::move(pixels)),
          use_(use),
          used_(pixels_.channels()),
          colours_(static_cast<std::size_t>(pixels_.colours())) {}

    void operator()(std::span<const std::uint8_t* const> planes, std::size_t count, void* to) {
        gather(planes, count);
        switch (pixels_.space) {
            case Space::Grey:
            case Space::Rgb:
                std::copy(values_.begin(), values_.end(), static_cast<Value*>(to));
                break;
            case Space::WhiteIsZero:
                invert(static_cast<Value*>(to));
                break;
            case Space::Palette:
                look_up(static_cast<std::uint16_t*>(to));
                break;
            case Space::Inks:
                convert_inks(static_cast<Value*>(to));
                break;
            case Space::YCbCr:
                convert_chroma(static_cast<Value*>(to));
                break;
            case Space::CieLab:
            case Space::IccLab:
                convert_lab(static_cast<std::uint16_t*>(to));
                break;
        }
    }

private:
    static constexpr auto kFull = std::is_integral_v<Value> ? std::numeric_limits<Value>::max() : Value{1};

    /// Copies the used channels to `values_`, interleaved.
    void gather(std::span<const std::uint8_t* const> planes, std::size_t count) {
        const std::size_t channels = used_.size();
        values_.resize(count * channels);
        const auto samples = static_cast<std::size_t>(pixels_.samples);
        if (!pixels_.is_planar && samples == channels) {
            unpack(planes[0], values_);
            return;
        }
        stored_.resize(pixels_.is_planar ? count : count * samples);
        for (std::size_t channel = 0; channel < channels; ++channel) {
            if (pixels_.is_planar || channel == 0) unpack(planes[channel], stored_);
            const std::size_t first = pixels_.is_planar ? 0 : used_[channel], step = pixels_.is_planar ? 1 : samples;
            for (std::size_t i = 0; i < count; ++i) values_[i * channels + channel] = stored_[first + i * step];
        }
    }

    void unpack(const std::uint8_t* from, std::vector<Value>& to) const {
        if (sizeof(Value) * 8 == static_cast<std::size_t>(pixels_.bits) && is_stored_as(pixels_.type)) {
            std::memcpy(to.data(), from, to.size() * sizeof(Value));
            return;
        }
        Codes codes(from, pixels_.bits);
        for (Value& value : to) value = decode(codes.next());
    }

    static bool is_stored_as(Type type) { return type == (std::is_integral_v<Value> ? Type::Unsigned : Type::Float); }

    Value decode(std::uint64_t code) const {
        if constexpr (std::is_same_v<Value, float>) {
            if (pixels_.type == Type::Float) return decode_float(code, pixels_.bits);
            if (pixels_.type == Type::Signed) return static_cast<float>(with_sign(code, pixels_.bits));
            return static_cast<float>(code);
        } else {
            if (pixels_.space == Space::Palette) return static_cast<Value>(code);
            return static_cast<Value>(to_word(code, pixels_.bits));
        }
    }

    bool has_alpha() const { return used_.size() > colours_; }

    /// Calls a function for each pixel, with the pixel's values and the address of its results, and copies alpha.
    template <class To, class Convert>
    void for_each_pixel(To* to, std::size_t results, const Convert& convert) const {
        for (std::size_t i = 0; i < values_.size(); i += used_.size(), to += results) {
            convert(&values_[i], to);
            if (has_alpha()) *(to++ + results) = alpha_of<To>(values_[i + colours_]);
        }
    }

    template <class To>
    To alpha_of(Value alpha) const {
        if constexpr (std::is_same_v<To, Value>) {
            return pixels_.space == Space::Palette
                       ? static_cast<To>(to_word(static_cast<std::uint64_t>(alpha), pixels_.bits))
                       : alpha;
        } else {
            return static_cast<To>(to_word(static_cast<std::uint64_t>(alpha), 8 * sizeof(Value)));
        }
    }

    /// Inverts grey. Premultiplied grey is inverted to premultiplied light.
    void invert(Value* to) const {
        for_each_pixel(to, 1, [this](const Value* from, Value* grey) {
            if (use_ == TiffUse::Values) {
                *grey = *from;
            } else {
                const Value white = pixels_.premultiplied ? from[1] : kFull;
                *grey = white > *from ? static_cast<Value>(white - *from) : Value{0};
            }
        });
    }

    void look_up(std::uint16_t* to) const {
        const std::size_t size = pixels_.palette.size() / 3;
        for_each_pixel(to, 3, [&](const Value* from, std::uint16_t* rgb) {
            const auto index = static_cast<std::size_t>(*from);
            for (std::size_t i = 0; i < 3; ++i) rgb[i] = pixels_.palette[i * size + index];
        });
    }

    /// Converts inks to the colours that they let through, unless the inks are to be kept.
    void convert_inks(Value* to) const {
        if (use_ == TiffUse::Inks) {
            std::copy(values_.begin(), values_.end(), to);
            return;
        }
        for_each_pixel(to, 3, [this](const Value* from, Value* rgb) {
            const float full = pixels_.premultiplied ? static_cast<float>(from[4]) : static_cast<float>(kFull);
            const auto passed = [full](Value ink) {
                return full > 0 ? 1 - std::clamp(static_cast<float>(ink) / full, 0.0F, 1.0F) : 1.0F;
            };
            for (std::size_t i = 0; i < 3; ++i) rgb[i] = to_value(passed(from[i]) * passed(from[3]));
        });
    }

    static Value to_value(float share) {
        if (!(share > 0)) return 0;
        const float value = std::min(share, 1.0F) * static_cast<float>(kFull);
        return std::is_integral_v<Value> ? static_cast<Value>(std::lround(value)) : static_cast<Value>(value);
    }

    /// Source: TIFF 6.0, 21.
    void convert_chroma(Value* to) const {
        constexpr float kFullCode = 255, kFullChroma = 127;
        const float red_weight = pixels_.luma[0], green_weight = pixels_.luma[1], blue_weight = pixels_.luma[2];
        const auto& black_white = pixels_.reference;
        for_each_pixel(to, 3, [&](const Value* from, Value* rgb) {
            const auto level = [&](std::size_t i, float full) {
                const float black = black_white[2 * i], white = black_white[2 * i + 1];
                return (static_cast<float>(from[i]) - black) * full / (white - black);
            };
            const float grey = level(0, kFullCode);
            const float red = level(2, kFullChroma) * (2 - 2 * red_weight) + grey;
            const float blue = level(1, kFullChroma) * (2 - 2 * blue_weight) + grey;
            const float green = (grey - blue_weight * blue - red_weight * red) / green_weight;
            rgb[0] = to_value(red / kFullCode);
            rgb[1] = to_value(green / kFullCode);
            rgb[2] = to_value(blue / kFullCode);
        });
    }

    /// Converts Lab to the encoding of ICC profiles, version 4: 65,535 is L* = 100, and a* and b* are 257 times their
    /// value plus 128. Source: TIFF 6.0, 23; Adobe's TIFF technical notes of 2002.
    void convert_lab(std::uint16_t* to) const {
        [[maybe_unused]] const bool is_icc = pixels_.space == Space::IccLab;
        for_each_pixel(to, 3, [&](const Value* from, std::uint16_t* lab) {
            if constexpr (std::is_same_v<Value, std::uint8_t>) {
                constexpr unsigned kSign = 0x80;
                lab[0] = to_word(from[0], 8);
                for (std::size_t i = 1; i < 3; ++i) lab[i] = to_word(is_icc ? from[i] : from[i] ^ kSign, 8);
            } else if constexpr (std::is_same_v<Value, std::uint16_t>) {
                constexpr unsigned kSign = 0x8000;
                // The fraction of 256 steps becomes one of 257 steps.
                const auto widen = [](std::uint64_t code) {
                    return static_cast<std::uint16_t>(std::min(code * 257 / 256, kFullWord));
                };
                lab[0] = is_icc ? widen(from[0]) : from[0];
                for (std::size_t i = 1; i < 3; ++i) lab[i] = widen(is_icc ? from[i] : from[i] ^ kSign);
            }
        });
    }

    TiffPixels pixels_;
    TiffUse use_;
    std::vector<std::uint16_t> used_;
    std::size_t colours_;
    std::vector<Value> stored_;
    std::vector<Value> values_;
};

}  // namespace

int TiffPixels::colours() const {
    switch (space) {
        case Space::WhiteIsZero:
        case Space::Grey:
        case Space::Palette:
            return 1;
        case Space::Inks:
            return 4;
        case Space::Rgb:
        case Space::YCbCr:
        case Space::CieLab:
        case Space::IccLab:
            break;
    }
    return 3;
}

std::vector<std::uint16_t> TiffPixels::channels() const {
    std::vector<std::uint16_t> used;
    used.reserve(static_cast<std::size_t>(colours()) + 1);
    for (int i = 0; i < colours(); ++i) used.push_back(static_cast<std::uint16_t>(i));
    if (alpha >= 0) used.push_back(static_cast<std::uint16_t>(alpha));
    return used;
}

RowSource describe_tiff_rows(const TiffPixels& pixels, TiffUse use) {
    RowSource source;
    source.sample = is_lab(pixels) ? Sample::Word : sample_of(pixels, use);
    source.curve = source.sample == Sample::Float ? RowSource::Curve::Linear : RowSource::Curve::Srgb;
    const bool keeps_inks = pixels.space == Space::Inks && use == TiffUse::Inks;
    if (is_lab(pixels)) source.space = RowSource::Space::Lab;
    if (keeps_inks) source.space = RowSource::Space::Inks;
    const bool is_grey = pixels.space == Space::Grey || pixels.space == Space::WhiteIsZero;
    const int colours = keeps_inks ? 4 : is_grey ? 1 : 3;
    source.alpha = pixels.alpha >= 0 ? colours : -1;
    source.channels = colours + (pixels.alpha >= 0 ? 1 : 0);
    source.premultiplied = pixels.premultiplied && (pixels.space != Space::Inks || keeps_inks);
    return source;
}

TiffRowConverter convert_tiff_rows(const TiffPixels& pixels, TiffUse use) {
    switch (sample_of(pixels, use)) {
        case Sample::Byte:
            return Converter<std::uint8_t>(pixels, use);
        case Sample::Word:
            return Converter<std::uint16_t>(pixels, use);
        case Sample::Float:
            break;
    }
    return Converter<float>(pixels, use);
}

std::size_t chroma_bytes(std::size_t width, std::size_t rows, std::size_t across, std::size_t down) {
    return (width + across - 1) / across * ((rows + down - 1) / down) * (across * down + 2);
}

void expand_chroma(const std::uint8_t* block, std::size_t width, std::size_t rows, std::size_t across, std::size_t down,
                   std::uint8_t* to) {
    const std::size_t unit = across * down + 2, row_of_units = chroma_bytes(width, 1, across, down);
    for (std::size_t y = 0; y < rows; ++y) {
        const std::uint8_t* const row = block + y / down * row_of_units;
        for (std::size_t x = 0; x < width; ++x, to += 3) {
            const std::uint8_t* const at = row + x / across * unit;
            to[0] = at[y % down * across + x % across];
            to[1] = at[unit - 2];
            to[2] = at[unit - 1];
        }
    }
}

}  // namespace ccdt::api
