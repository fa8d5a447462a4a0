// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/tiff_reader.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/image/image_codec.h"
#include "api/image/image_header.h"

namespace ccdt::api {
namespace {

constexpr int kWidth = 39, kHeight = 29;
constexpr std::size_t kMaxPixels = 100'000;

using Rgb = std::array<double, 3>;

/// Kind of a TIFF, and the tags that it needs.
struct Kind {
    std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
    int bits = 8;
    std::uint16_t format = SAMPLEFORMAT_UINT;
    std::uint16_t compression = COMPRESSION_NONE;
    bool is_planar = false;
    int tile = 0;  ///< side of tiles; 0: strips
    std::vector<std::uint16_t> extras = {};
    int predictor = PREDICTOR_NONE;
    bool is_big_endian = false;
    int orientation = ORIENTATION_TOPLEFT;
    std::array<std::uint16_t, 2> subsampling = {1, 1};
    std::function<void(TIFF*)> tags = {};  ///< sets more tags
    int strip = 8;                         ///< rows of a strip
    bool is_big = false;                   ///< whether the file is a BigTIFF

    std::string name() const {
        return "photometric " + std::to_string(photometric) + " bits " + std::to_string(bits) + " format " +
               std::to_string(format) + " compression " + std::to_string(compression) + (is_planar ? " planar" : "") +
               (tile > 0 ? " tiled" : "") + " extras " + std::to_string(extras.size()) + " predictor " +
               std::to_string(predictor) + (is_big ? " BigTIFF" : "") + (is_big_endian ? " big-endian" : "") +
               " orientation " + std::to_string(orientation) + " chroma " + std::to_string(subsampling[0]) +
               std::to_string(subsampling[1]);
    }

    int colours() const {
        if (photometric == PHOTOMETRIC_SEPARATED) return 4;
        return photometric <= PHOTOMETRIC_MINISBLACK || photometric == PHOTOMETRIC_PALETTE ? 1 : 3;
    }
    int samples() const { return colours() + static_cast<int>(extras.size()); }
};

/// Memory to which libtiff writes.
struct Output {
    std::string bytes;
    std::size_t position = 0;
};

std::string write_file(const Kind& kind, const std::function<bool(TIFF*)>& write) {
    Output output;
    TIFFSetWarningHandler(nullptr);
    TIFF* const tiff = TIFFClientOpen(
        "", (std::string(kind.is_big_endian ? "wb" : "wl") + (kind.is_big ? "8" : "4")).c_str(), &output,
        [](thandle_t handle, void* target, tmsize_t size) -> tmsize_t {
            Output& file = *static_cast<Output*>(handle);
            return static_cast<tmsize_t>(
                file.bytes.copy(static_cast<char*>(target), static_cast<std::size_t>(size), file.position));
        },
        [](thandle_t handle, void* source, tmsize_t size) {
            Output& file = *static_cast<Output*>(handle);
            const auto count = static_cast<std::size_t>(size);
            if (file.bytes.size() < file.position + count) file.bytes.resize(file.position + count);
            std::memcpy(file.bytes.data() + file.position, source, count);
            file.position += count;
            return size;
        },
        [](thandle_t handle, toff_t offset, int whence) -> toff_t {
            Output& file = *static_cast<Output*>(handle);
            return file.position = (whence == SEEK_END   ? file.bytes.size()
                                    : whence == SEEK_CUR ? file.position
                                                         : 0) +
                                   offset;
        },
        [](thandle_t) { return 0; },
        [](thandle_t handle) -> toff_t { return static_cast<Output*>(handle)->bytes.size(); }, nullptr, nullptr);
    EXPECT_TRUE(write(tiff)) << kind.name();
    TIFFClose(tiff);
    return output.bytes;
}

/// Encodes a float of 16 or 24 bits from 2^-14 to 1, or 0.
std::uint64_t encode_float(double value, int exponent_bits, int mantissa_bits) {
    if (value <= 0) return 0;
    const int exponent = static_cast<int>(std::floor(std::log2(value)));
    const auto mantissa = static_cast<std::uint64_t>(
        std::lround((std::ldexp(value, -exponent) - 1) * static_cast<double>(1 << mantissa_bits)));
    const auto biased = static_cast<std::uint64_t>(exponent + (1 << (exponent_bits - 1)) - 1);
    return (biased << mantissa_bits) + mantissa;
}

/// Encodes a share of the full range as a stored sample.
std::uint64_t encode(double share, const Kind& kind) {
    if (kind.format == SAMPLEFORMAT_IEEEFP) {
        if (kind.bits == 16) return encode_float(share, 5, 10);
        if (kind.bits == 24) return encode_float(share, 7, 16);
        if (kind.bits == 32) return std::bit_cast<std::uint32_t>(static_cast<float>(share));
        return std::bit_cast<std::uint64_t>(share);
    }
    return static_cast<std::uint64_t>(std::llround(share * static_cast<double>((std::uint64_t{1} << kind.bits) - 1)));
}

/// Appends samples to a row: whole bytes in the machine's order, others from the highest bit to the lowest.
std::vector<std::uint8_t> pack(const std::vector<std::uint64_t>& codes, int bits) {
    std::vector<std::uint8_t> row;
    std::uint64_t buffer = 0;
    int held = 0;
    for (const std::uint64_t code : codes) {
        if (bits % 8 == 0) {
            const auto* const bytes = reinterpret_cast<const std::uint8_t*>(&code);
            row.insert(row.end(), bytes, bytes + bits / 8);
            continue;
        }
        buffer = buffer << bits | code;
        for (held += bits; held >= 8; held -= 8) row.push_back(static_cast<std::uint8_t>(buffer >> (held - 8)));
    }
    if (held > 0) row.push_back(static_cast<std::uint8_t>(buffer << (8 - held)));
    return row;
}

/// Colour of a pixel of the test picture, which is smooth and has no symmetry.
Rgb scene(int x, int y) {
    const double u = static_cast<double>(x) / (kWidth - 1), v = static_cast<double>(y) / (kHeight - 1);
    return {u, 0.2 + 0.6 * v, 0.9 - 0.4 * u - 0.4 * v};
}

double alpha_of(int x, int y) {
    return (x + y) % 4 * 0.2 + 0.4;
}

double light_of(double share) {
    return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
}

/// CIELAB of an sRGB colour, relative to the white D50. The matrix is that of the sRGB profile.
Rgb lab_of(const Rgb& rgb) {
    constexpr double kMatrix[3][3] = {
        {0.4360747, 0.3850649, 0.1430804}, {0.2225045, 0.7168786, 0.0606169}, {0.0139322, 0.0971045, 0.7141733}};
    constexpr double kWhite[3] = {0.96422, 1, 0.82521};
    double f[3];
    for (int i = 0; i < 3; ++i) {
        double value = 0;
        for (std::size_t j = 0; j < 3; ++j) value += kMatrix[i][j] * light_of(rgb[j]);
        value /= kWhite[i];
        f[i] = value > 216.0 / 24389 ? std::cbrt(value) : (24389.0 / 27 * value + 16) / 116;
    }
    return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

/// Stored samples of a pixel, and the colour and alpha that they mean.
struct Pixel {
    std::vector<std::uint64_t> codes;
    Rgb rgb{};
    double alpha = 1;
};

Pixel make_pixel(const Kind& kind, int x, int y) {
    Pixel pixel;
    const Rgb colour = scene(x, y);
    const double full =
        kind.format == SAMPLEFORMAT_IEEEFP ? 1 : static_cast<double>((std::uint64_t{1} << kind.bits) - 1);
    const auto put = [&](double share) {
        pixel.codes.push_back(encode(share, kind));
        return kind.format == SAMPLEFORMAT_IEEEFP ? share : static_cast<double>(pixel.codes.back()) / full;
    };
    const auto associated = std::ranges::find(kind.extras, EXTRASAMPLE_ASSOCALPHA) != kind.extras.end();
    if (std::ranges::any_of(kind.extras, [](auto extra) { return extra != EXTRASAMPLE_UNSPECIFIED; }))
        pixel.alpha = alpha_of(x, y);
    const double factor = associated ? pixel.alpha : 1;
    switch (kind.photometric) {
        case PHOTOMETRIC_MINISWHITE: {
            const double grey = 1 - put(factor * (1 - colour[0]));
            pixel.rgb = {grey, grey, grey};
            if (associated) pixel.rgb = {colour[0], colour[0], colour[0]};
            break;
        }
        case PHOTOMETRIC_MINISBLACK: {
            const double grey = put(factor * colour[0]) / factor;
            pixel.rgb = {grey, grey, grey};
            break;
        }
        case PHOTOMETRIC_RGB:
            for (std::size_t i = 0; i < 3; ++i) pixel.rgb[i] = put(factor * colour[i]) / factor;
            break;
        case PHOTOMETRIC_PALETTE: {
            const double share = put(colour[0]);
            pixel.rgb = {share, 1 - share, share / 2};
            break;
        }
        case PHOTOMETRIC_SEPARATED: {
            const double black = 0.3 * colour[1];
            for (std::size_t i = 0; i < 3; ++i) pixel.rgb[i] = 1 - put(factor * (1 - colour[i])) / factor;
            const double passed = 1 - put(factor * black) / factor;
            for (double& value : pixel.rgb) value *= passed;
            break;
        }
        case PHOTOMETRIC_YCBCR: {
            const double grey = 0.299 * colour[0] + 0.587 * colour[1] + 0.114 * colour[2];
            put(grey);
            put(std::clamp((colour[2] - grey) / 1.772 + 128 / 255.0, 0.0, 1.0));
            put(std::clamp((colour[0] - grey) / 1.402 + 128 / 255.0, 0.0, 1.0));
            pixel.rgb = colour;
            break;
        }
        default: {
            const Rgb lab = lab_of(colour);
            const bool is_icc = kind.photometric == PHOTOMETRIC_ICCLAB;
            const double step = kind.bits == 16 ? 256 : 1;
            const double white = kind.bits == 8 ? 255 : is_icc ? 65280 : 65535;
            pixel.codes.push_back(static_cast<std::uint64_t>(std::lround(lab[0] / 100 * white)));
            for (std::size_t i = 1; i < 3; ++i) {
                const auto code = std::lround((lab[i] + (is_icc ? 128 : 0)) * step);
                pixel.codes.push_back(static_cast<std::uint64_t>(code) & static_cast<std::uint64_t>(full));
            }
            pixel.rgb = colour;
        }
    }
    for (const auto extra : kind.extras) put(extra == EXTRASAMPLE_UNSPECIFIED ? 0.1 : pixel.alpha);
    return pixel;
}

/// Returns the codes of a block, which starts at a pixel and may exceed the picture. Chroma may be subsampled.
std::vector<std::uint8_t> make_block(const Kind& kind, int left, int top, int columns, int rows, int plane) {
    std::vector<std::uint8_t> block;
    const auto codes_at = [&](int x, int y) {
        return make_pixel(kind, std::min(x, kWidth - 1), std::min(y, kHeight - 1)).codes;
    };
    const auto [across, down] = kind.subsampling;
    if (across * down > 1) {
        for (int y = 0; y < rows; y += down) {
            for (int x = 0; x < columns; x += across) {
                for (int i = 0; i < down * across; ++i)
                    block.push_back(
                        static_cast<std::uint8_t>(codes_at(left + x + i % across, top + y + i / across)[0]));
                const auto chroma = codes_at(left + x + across / 2, top + y + down / 2);
                block.push_back(static_cast<std::uint8_t>(chroma[1]));
                block.push_back(static_cast<std::uint8_t>(chroma[2]));
            }
        }
        return block;
    }
    for (int y = 0; y < rows; ++y) {
        std::vector<std::uint64_t> codes;
        for (int x = 0; x < columns; ++x) {
            const auto pixel = codes_at(left + x, top + y);
            if (kind.is_planar) {
                codes.push_back(pixel[static_cast<std::size_t>(plane)]);
            } else {
                codes.insert(codes.end(), pixel.begin(), pixel.end());
            }
        }
        const auto row = pack(codes, kind.bits);
        block.insert(block.end(), row.begin(), row.end());
    }
    return block;
}

bool write_tags(TIFF* tiff, const Kind& kind) {
    bool done = TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth) && TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight) &&
                TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits) &&
                TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kind.samples()) &&
                TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, kind.format) &&
                TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kind.photometric) &&
                TIFFSetField(tiff, TIFFTAG_ORIENTATION, kind.orientation) &&
                TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression) &&
                TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, kind.is_planar ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    if (kind.predictor != PREDICTOR_NONE) done = done && TIFFSetField(tiff, TIFFTAG_PREDICTOR, kind.predictor);
    if (kind.compression == COMPRESSION_WEBP) done = done && TIFFSetField(tiff, TIFFTAG_WEBP_LOSSLESS, 1);
    if (kind.compression == COMPRESSION_JPEG) {
        done = done && TIFFSetField(tiff, TIFFTAG_JPEGQUALITY, 98);
        if (kind.photometric == PHOTOMETRIC_YCBCR) TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    }
    if (!kind.extras.empty())
        done = done && TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, kind.extras.size(), kind.extras.data());
    if (kind.photometric == PHOTOMETRIC_YCBCR)
        done = done && TIFFSetField(tiff, TIFFTAG_YCBCRSUBSAMPLING, kind.subsampling[0], kind.subsampling[1]);
    if (kind.photometric == PHOTOMETRIC_PALETTE) {
        const std::size_t size = std::size_t{1} << kind.bits;
        std::vector<std::uint16_t> maps(3 * size);
        for (std::size_t i = 0; i < size; ++i) {
            const double share = static_cast<double>(i) / static_cast<double>(size - 1);
            maps[i] = static_cast<std::uint16_t>(std::lround(65535 * share));
            maps[size + i] = static_cast<std::uint16_t>(65535 - maps[i]);
            maps[2 * size + i] = static_cast<std::uint16_t>(maps[i] / 2);
        }
        done = done && TIFFSetField(tiff, TIFFTAG_COLORMAP, &maps[0], &maps[size], &maps[2 * size]);
    }
    if (kind.tile > 0) {
        done = done && TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kind.tile) &&
               TIFFSetField(tiff, TIFFTAG_TILELENGTH, kind.tile);
    } else {
        done = done && TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, kind.strip);
    }
    if (kind.tags) kind.tags(tiff);
    return done;
}

bool write_blocks(TIFF* tiff, Kind kind) {
    // libtiff converts the colours of a JPEG and subsamples the chroma itself.
    if (kind.compression == COMPRESSION_JPEG) {
        kind.subsampling = {1, 1};
        if (kind.photometric == PHOTOMETRIC_YCBCR) kind.photometric = PHOTOMETRIC_RGB;
    }
    const int columns = kind.tile > 0 ? kind.tile : kWidth, rows = kind.tile > 0 ? kind.tile : kind.strip;
    std::uint32_t index = 0;
    for (int plane = 0; plane < (kind.is_planar ? kind.samples() : 1); ++plane) {
        for (int y = 0; y < kHeight; y += rows) {
            for (int x = 0; x < kWidth; x += columns, ++index) {
                auto block = make_block(kind, x, y, columns, kind.tile > 0 ? rows : std::min(rows, kHeight - y), plane);
                const auto size = static_cast<tmsize_t>(block.size());
                const auto written = kind.tile > 0 ? TIFFWriteEncodedTile(tiff, index, block.data(), size)
                                                   : TIFFWriteEncodedStrip(tiff, index, block.data(), size);
                if (written < 0) return false;
            }
        }
    }
    return true;
}

std::string make_tiff(const Kind& kind) {
    return write_file(kind, [&](TIFF* tiff) { return write_tags(tiff, kind) && write_blocks(tiff, kind); });
}

/// Returns the CIE lightness of a luminance.
double lightness_of(double luminance) {
    return luminance > 216.0 / 24389 ? 116 * std::cbrt(luminance) - 16 : luminance * 24389 / 27;
}

/// Returns the index in the upright picture of a stored pixel.
std::size_t position_of(int x, int y, int orientation, int width) {
    const int right = kWidth - 1 - x, bottom = kHeight - 1 - y;
    const std::array<std::array<int, 2>, 8> positions = {
        {{x, y}, {right, y}, {right, bottom}, {x, bottom}, {y, x}, {bottom, x}, {bottom, right}, {y, right}}};
    const auto [column, row] = positions[static_cast<std::size_t>(orientation - 1)];
    return static_cast<std::size_t>(row * width + column);
}

/// Checks that every pixel of a file has the colour of the test picture.
/// @param tolerance  greatest difference in L*
void expect_scene(const Kind& kind, double tolerance = 1) {
    const std::string file = make_tiff(kind);
    const auto picture = decode_colour_image(file, kMaxPixels);
    ASSERT_TRUE(picture) << kind.name() << ": " << picture.error().message;
    ASSERT_EQ(picture->width, kind.orientation < 5 ? kWidth : kHeight) << kind.name();
    ASSERT_EQ(picture->red.size(), std::size_t{kWidth} * kHeight) << kind.name();
    const bool is_linear = kind.format == SAMPLEFORMAT_IEEEFP;
    bool has_alpha = false;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const Pixel pixel = make_pixel(kind, x, y);
            const std::size_t i = position_of(x, y, kind.orientation, picture->width);
            const std::array<float, 3> found = {picture->red[i], picture->green[i], picture->blue[i]};
            for (std::size_t channel = 0; channel < 3; ++channel) {
                const double light = is_linear ? pixel.rgb[channel] : light_of(pixel.rgb[channel]);
                ASSERT_NEAR(lightness_of(found[channel]), lightness_of(light), tolerance)
                    << kind.name() << ' ' << x << ' ' << y << ' ' << channel;
            }
            has_alpha = has_alpha || pixel.alpha < 1;
            if (pixel.alpha < 1) {
                ASSERT_NEAR(picture->alpha[i], pixel.alpha, 0.6 / ((1 << std::min(kind.bits, 16)) - 1)) << kind.name();
            }
        }
    }
    EXPECT_EQ(picture->alpha.empty(), !has_alpha) << kind.name();
}

/// Calls a function with every layout of the pixels of a kind.
void for_each_layout(Kind kind, const std::function<void(const Kind&)>& check) {
    for (const bool is_planar : {false, true}) {
        for (const int tile : {0, 16, 48}) {
            for (const bool is_big_endian : {false, true}) {
                kind.is_planar = is_planar;
                kind.tile = tile;
                kind.is_big_endian = is_big_endian;
                check(kind);
            }
        }
    }
}

TEST(TiffReader, ReadsIntegersOfAnySizeInEveryLayout) {
    for (const auto photometric :
         {PHOTOMETRIC_MINISWHITE, PHOTOMETRIC_MINISBLACK, PHOTOMETRIC_RGB, PHOTOMETRIC_SEPARATED}) {
        for (const int bits : {1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 32}) {
            for_each_layout({.photometric = static_cast<std::uint16_t>(photometric), .bits = bits},
                            [](const Kind& kind) { expect_scene(kind); });
        }
    }
}

TEST(TiffReader, ReadsFloatsOfEverySizeInEveryLayout) {
    for (const auto photometric :
         {PHOTOMETRIC_MINISWHITE, PHOTOMETRIC_MINISBLACK, PHOTOMETRIC_RGB, PHOTOMETRIC_SEPARATED}) {
        for (const int bits : {16, 24, 32, 64}) {
            for_each_layout(
                {.photometric = static_cast<std::uint16_t>(photometric), .bits = bits, .format = SAMPLEFORMAT_IEEEFP},
                [](const Kind& kind) { expect_scene(kind); });
        }
    }
}

TEST(TiffReader, ReadsBigTiffs) {
    for (const auto photometric : {PHOTOMETRIC_MINISBLACK, PHOTOMETRIC_PALETTE, PHOTOMETRIC_RGB}) {
        for_each_layout({.photometric = static_cast<std::uint16_t>(photometric), .is_big = true},
                        [](const Kind& kind) { expect_scene(kind); });
    }
    for (const bool is_big_endian : {false, true}) {
        const Kind kind{.is_big_endian = is_big_endian, .is_big = true};
        const std::string pages = write_file(kind, [&](TIFF* tiff) {
            const auto write_page = [&] { return write_tags(tiff, kind) && write_blocks(tiff, kind); };
            return write_page() && TIFFWriteDirectory(tiff) != 0 && write_page();
        });
        EXPECT_EQ(read_image_header(pages, kMaxPixels)->frames, 2U);
    }
}

TEST(TiffReader, ReadsPalettesAndLab) {
    for (const int bits : {1, 2, 4, 8, 16})
        for_each_layout({.photometric = PHOTOMETRIC_PALETTE, .bits = bits},
                        [](const Kind& kind) { expect_scene(kind); });
    for (const auto photometric : {PHOTOMETRIC_CIELAB, PHOTOMETRIC_ICCLAB}) {
        for (const int bits : {8, 16}) {
            const double tolerance = bits == 8 ? 6 : 1;  // steps of 1 in a* and b*
            for_each_layout({.photometric = static_cast<std::uint16_t>(photometric), .bits = bits},
                            [&](const Kind& kind) { expect_scene(kind, tolerance); });
        }
    }
}

TEST(TiffReader, ReadsExtraSamples) {
    constexpr std::uint16_t kOther = EXTRASAMPLE_UNSPECIFIED, kAlpha = EXTRASAMPLE_UNASSALPHA,
                            kMultiplied = EXTRASAMPLE_ASSOCALPHA;
    for (const auto photometric : {PHOTOMETRIC_MINISWHITE, PHOTOMETRIC_MINISBLACK, PHOTOMETRIC_RGB,
                                   PHOTOMETRIC_SEPARATED, PHOTOMETRIC_PALETTE, PHOTOMETRIC_YCBCR, PHOTOMETRIC_CIELAB}) {
        const bool is_premultiplied = photometric <= PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_SEPARATED;
        for (const auto& extras : std::vector<std::vector<std::uint16_t>>{{kOther},
                                                                          {kAlpha},
                                                                          {kMultiplied},
                                                                          {kOther, kAlpha},
                                                                          {kAlpha, kOther, kOther},
                                                                          {kOther, kOther, kOther}}) {
            if (extras[0] == kMultiplied && !is_premultiplied) continue;
            for (const int bits : {8, 16}) {
                if (bits == 16 && photometric == PHOTOMETRIC_YCBCR) continue;
                const double tolerance = bits == 8 && photometric >= PHOTOMETRIC_YCBCR ? 6 : 1.5;
                for_each_layout(
                    {.photometric = static_cast<std::uint16_t>(photometric), .bits = bits, .extras = extras},
                    [&](const Kind& kind) {
                        if (photometric != PHOTOMETRIC_YCBCR || kind.is_planar) expect_scene(kind, tolerance);
                    });
            }
        }
    }
}

TEST(TiffReader, ReadsEveryCompression) {
    for (const auto compression : {COMPRESSION_LZW, COMPRESSION_PACKBITS, COMPRESSION_ADOBE_DEFLATE,
                                   COMPRESSION_DEFLATE, COMPRESSION_LZMA, COMPRESSION_ZSTD}) {
        for (const auto photometric :
             {PHOTOMETRIC_MINISWHITE, PHOTOMETRIC_RGB, PHOTOMETRIC_SEPARATED, PHOTOMETRIC_PALETTE}) {
            for (const int bits : {1, 4, 8, 16}) {
                for_each_layout({.photometric = static_cast<std::uint16_t>(photometric),
                                 .bits = bits,
                                 .compression = static_cast<std::uint16_t>(compression)},
                                [](const Kind& kind) { expect_scene(kind); });
            }
        }
    }
    for_each_layout({.photometric = PHOTOMETRIC_RGB, .compression = COMPRESSION_WEBP}, [](const Kind& kind) {
        if (!kind.is_planar) expect_scene(kind);
    });
}

TEST(TiffReader, ReadsDifferences) {
    for (const auto compression : {COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_ZSTD}) {
        for (const auto photometric : {PHOTOMETRIC_MINISBLACK, PHOTOMETRIC_RGB, PHOTOMETRIC_SEPARATED}) {
            const auto expect = [&](int bits, std::uint16_t format, int predictor) {
                for_each_layout({.photometric = static_cast<std::uint16_t>(photometric),
                                 .bits = bits,
                                 .format = format,
                                 .compression = static_cast<std::uint16_t>(compression),
                                 .predictor = predictor},
                                [](const Kind& kind) {
                                    // libtiff 4.5 writes these differences in the wrong order of bytes.
                                    if (kind.is_big_endian && kind.predictor == PREDICTOR_FLOATINGPOINT) return;
                                    expect_scene(kind);
                                });
            };
            for (const int bits : {8, 16, 32}) expect(bits, SAMPLEFORMAT_UINT, PREDICTOR_HORIZONTAL);
            for (const int bits : {16, 24, 32, 64}) expect(bits, SAMPLEFORMAT_IEEEFP, PREDICTOR_FLOATINGPOINT);
        }
    }
}

TEST(TiffReader, ReadsFax) {
    for (const auto compression : {COMPRESSION_CCITTRLE, COMPRESSION_CCITTFAX3, COMPRESSION_CCITTFAX4}) {
        for (const auto photometric : {PHOTOMETRIC_MINISWHITE, PHOTOMETRIC_MINISBLACK}) {
            for (const int tile : {0, 16}) {
                expect_scene({.photometric = static_cast<std::uint16_t>(photometric),
                              .bits = 1,
                              .compression = static_cast<std::uint16_t>(compression),
                              .tile = tile});
            }
        }
    }
}

TEST(TiffReader, ReadsJpegInEveryColourSpace) {
    for (const auto photometric :
         {PHOTOMETRIC_MINISWHITE, PHOTOMETRIC_MINISBLACK, PHOTOMETRIC_RGB, PHOTOMETRIC_SEPARATED}) {
        for_each_layout({.photometric = static_cast<std::uint16_t>(photometric), .compression = COMPRESSION_JPEG},
                        [](const Kind& kind) { expect_scene(kind, 5); });
    }
    for (const std::uint16_t across : std::vector<std::uint16_t>{1, 2}) {
        for (const std::uint16_t down : std::vector<std::uint16_t>{1, 2}) {
            for (const int tile : {0, 16}) {
                expect_scene({.photometric = PHOTOMETRIC_YCBCR,
                              .compression = COMPRESSION_JPEG,
                              .tile = tile,
                              .subsampling = {across, down},
                              .strip = 16},
                             5);
            }
        }
    }
}

TEST(TiffReader, ReadsSubsampledChroma) {
    for (const std::uint16_t across : std::vector<std::uint16_t>{1, 2, 4}) {
        for (const std::uint16_t down : std::vector<std::uint16_t>{1, 2, 4}) {
            for (const int tile : {0, 16}) {
                for (const auto compression : {COMPRESSION_NONE, COMPRESSION_LZW}) {
                    expect_scene(
                        {.photometric = PHOTOMETRIC_YCBCR,
                         .compression = static_cast<std::uint16_t>(compression),
                         .tile = tile,
                         .subsampling = {across, down}},
                        across * down == 1 ? 1.5 : 5 + across + down);  // in darkness, a step of chroma is large
                }
            }
        }
    }
}

TEST(TiffReader, AppliesEveryOrientationInEveryColourSpace) {
    for (int orientation = 1; orientation <= 8; ++orientation) {
        for (const int tile : {0, 16}) {
            for (const auto photometric :
                 {PHOTOMETRIC_MINISBLACK, PHOTOMETRIC_RGB, PHOTOMETRIC_SEPARATED, PHOTOMETRIC_YCBCR}) {
                for (const auto compression : {COMPRESSION_NONE, COMPRESSION_JPEG}) {
                    expect_scene({.photometric = static_cast<std::uint16_t>(photometric),
                                  .compression = static_cast<std::uint16_t>(compression),
                                  .tile = tile,
                                  .orientation = orientation},
                                 5);
                }
            }
        }
    }
}

TEST(TiffReader, IgnoresTheOffsetOnThePage) {
    expect_scene({.photometric = PHOTOMETRIC_RGB, .tags = [](TIFF* tiff) {
                      TIFFSetField(tiff, TIFFTAG_XPOSITION, 3.0F);
                      TIFFSetField(tiff, TIFFTAG_YPOSITION, 10.0F);
                  }});
}

TEST(TiffReader, ScalesPalettesOfEightBits) {
    std::vector<std::uint16_t> map(256);
    for (std::size_t i = 0; i < 256; ++i) map[i] = static_cast<std::uint16_t>(i);
    Kind kind{.photometric = PHOTOMETRIC_PALETTE};
    kind.tags = [&map](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_COLORMAP, map.data(), map.data(), map.data()); };
    const auto picture = decode_image(make_tiff(kind), kMaxPixels);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_NEAR(picture->luminance[kWidth - 1], 1, 1e-6);
}

/// Returns the offset of the entry of a tag in a little-endian file.
std::size_t entry_of(const std::string& file, unsigned tag) {
    const auto number = [&](std::size_t at, std::size_t size) {
        std::uint32_t value = 0;
        std::memcpy(&value, file.data() + at, size);
        return value;
    };
    const std::size_t first = number(4, 4) + 2;
    for (std::size_t i = 0; i < number(first - 2, 2); ++i) {
        if (number(first + 12 * i, 2) == tag) return first + 12 * i;
    }
    ADD_FAILURE() << "no tag " << tag;
    return 0;
}

/// Replaces the first 16 bits of a tag's value.
std::string with_value(std::string file, unsigned tag, std::uint16_t value) {
    std::memcpy(file.data() + entry_of(file, tag) + 8, &value, sizeof(value));
    return file;
}

TEST(TiffReader, AssumesDefaultsOfMissingTags) {
    const auto with = decode_image(make_tiff({.bits = 1}), kMaxPixels);
    // The entry becomes a second, equal height, since entries must be in order.
    std::string file = make_tiff({.bits = 1});
    const std::size_t height = entry_of(file, TIFFTAG_IMAGELENGTH), bits = entry_of(file, TIFFTAG_BITSPERSAMPLE);
    file.replace(bits, 12, file, height, 12);
    const auto without_bits = decode_image(file, kMaxPixels);
    ASSERT_TRUE(with && without_bits) << without_bits.error().message;
    EXPECT_EQ(with->luminance, without_bits->luminance);
}

void expect_refused(const std::string& file, const std::string& words) {
    const auto picture = decode_image(file, kMaxPixels);
    ASSERT_FALSE(picture) << words;
    EXPECT_EQ(picture.error().code, ErrorCode::Unusable) << words;
    EXPECT_NE(picture.error().message.find("there is no support for this kind of TIFF: "), std::string::npos)
        << picture.error().message;
    EXPECT_NE(picture.error().message.find(words), std::string::npos) << picture.error().message;
}

TEST(TiffReader, NamesKindsThatItDoesNotRead) {
    const std::string grey = make_tiff({}), rgb = make_tiff({.photometric = PHOTOMETRIC_RGB});
    for (const int bits : {8, 16, 32})
        expect_refused(make_tiff({.bits = bits, .format = SAMPLEFORMAT_INT}),
                       std::to_string(bits) + "-bit signed grey");
    expect_refused(make_tiff({.photometric = PHOTOMETRIC_CIELAB, .bits = 32}), "32-bit CIELAB");
    expect_refused(make_tiff({.photometric = PHOTOMETRIC_PALETTE, .format = SAMPLEFORMAT_INT}), "8-bit signed palette");
    const std::vector<std::uint16_t> many(14, EXTRASAMPLE_UNSPECIFIED);
    expect_refused(make_tiff({.photometric = PHOTOMETRIC_RGB, .bits = 16, .extras = many}),
                   "16-bit RGB with 14 extra channels");
    expect_refused(make_tiff({.photometric = PHOTOMETRIC_SEPARATED,
                              .tags = [](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_INKSET, INKSET_MULTIINK); }}),
                   "inks other than cyan, magenta, yellow and black");
    for (const auto& [photometric, words] :
         std::vector<std::pair<std::uint16_t, const char*>>{{PHOTOMETRIC_MASK, "a transparency mask"},
                                                            {PHOTOMETRIC_CFA, "the raw data of a camera's sensor"},
                                                            {34892, "the raw data of a camera's sensor"},
                                                            {PHOTOMETRIC_LOGL, "LogLuv"},
                                                            {999, "interpretation 999"}})
        expect_refused(with_value(grey, TIFFTAG_PHOTOMETRIC, photometric), words);
    for (const auto& [compression, words] :
         std::vector<std::pair<std::uint16_t, const char*>>{{COMPRESSION_OJPEG, "compression 6 (Old-style JPEG)"},
                                                            {COMPRESSION_JP2000, "compression 34712"},
                                                            {COMPRESSION_LERC, "LERC"},
                                                            {COMPRESSION_CCITTFAX4, "8-bit RGB with"}})
        expect_refused(
            with_value(compression == COMPRESSION_CCITTFAX4 ? make_tiff({.photometric = PHOTOMETRIC_RGB, .extras = {0}})
                                                            : grey,
                       TIFFTAG_COMPRESSION, compression),
            words);
    std::string lossless = make_tiff({.compression = COMPRESSION_JPEG});
    lossless[lossless.find("\xff\xc0") + 1] = '\xc3';
    expect_refused(lossless, "8-bit grey, compressed as a JPEG with lossless or hierarchical coding");
    expect_refused(make_tiff({.tags = [](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_IMAGEDEPTH, 2); }}), "dimensions");
    expect_refused(make_tiff({.tags =
                                  [](TIFF* tiff) {
                                      const std::array<std::uint8_t, 4> version = {1, 4, 0, 0};
                                      TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
                                      TIFFSetField(tiff, TIFFTAG_DNGVERSION, version.data());
                                  }}),
                   "thumbnail");
    std::string uneven = rgb;
    std::size_t bits = 0;
    std::memcpy(&bits, rgb.data() + entry_of(rgb, TIFFTAG_BITSPERSAMPLE) + 8, 4);
    uneven[bits + 2] = 6;
    expect_refused(uneven, "channels of 8 and 6 bits");
    std::string long_directory = grey;
    std::size_t directory = 0;
    std::memcpy(&directory, grey.data() + 4, 4);
    long_directory.replace(directory, 2, "\x01\x10");
    expect_refused(long_directory, "4097 tags; the limit is 4096");
}

TEST(TiffReader, KeepsTheValuesOfStacks) {
    Reading reading(kMaxPixels);
    reading.is_stack = true;
    for (const int bits : {8, 16, 32}) {
        for (const std::uint16_t format : std::vector<std::uint16_t>{SAMPLEFORMAT_UINT, SAMPLEFORMAT_INT}) {
            const Kind kind{.bits = bits, .format = format};
            const auto stack = decode_image(make_tiff(kind), reading);
            ASSERT_TRUE(stack) << kind.name() << ": " << stack.error().message;
            for (int x = 0; x < kWidth; ++x) {
                const auto code = static_cast<std::int64_t>(make_pixel(kind, x, 0).codes[0]);
                const bool is_negative = format == SAMPLEFORMAT_INT && (code >> (bits - 1) & 1) != 0;
                const std::int64_t value = is_negative ? code - (std::int64_t{1} << bits) : code;
                EXPECT_EQ(stack->luminance[static_cast<std::size_t>(x)], static_cast<float>(value)) << kind.name();
            }
        }
    }
}

TEST(TiffReader, RefusesTruncatedFilesOfEveryCompression) {
    for (const auto compression : {COMPRESSION_LZW, COMPRESSION_PACKBITS, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_LZMA,
                                   COMPRESSION_ZSTD, COMPRESSION_JPEG}) {
        for (const int tile : {0, 16}) {
            // Halves the length of the first block, because libtiff writes the directory last.
            const Kind kind{
                .photometric = PHOTOMETRIC_RGB, .compression = static_cast<std::uint16_t>(compression), .tile = tile};
            std::string file = make_tiff(kind);
            const std::size_t counts = entry_of(file, tile > 0 ? TIFFTAG_TILEBYTECOUNTS : TIFFTAG_STRIPBYTECOUNTS);
            std::uint32_t at = 0, type = 0, first = 0;
            std::memcpy(&type, file.data() + counts + 2, 2);
            std::memcpy(&at, file.data() + counts + 8, 4);
            const std::size_t size = type == TIFF_SHORT ? 2 : 4;
            std::memcpy(&first, file.data() + at, size);
            first = first / 2;
            std::memcpy(file.data() + at, &first, size);
            EXPECT_FALSE(decode_image(file, kMaxPixels)) << kind.name();
        }
    }
}

}  // namespace
}  // namespace ccdt::api
