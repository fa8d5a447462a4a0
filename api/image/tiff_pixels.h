// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "api/image/row_source.h"

namespace ccdt::api {

/// Use that is made of the pixels of a TIFF.
enum class TiffUse {
    Light,  ///< colours as grey or RGB, or as Lab; inks are converted to RGB
    Inks,   ///< the same, but inks are kept
    Values  ///< grey samples of any type as they are stored
};

/// Storage and meaning of the samples of a TIFF.
struct TiffPixels {
    enum class Space { WhiteIsZero, Grey, Rgb, Palette, Inks, YCbCr, CieLab, IccLab };
    enum class Type { Unsigned, Signed, Float };

    Space space = Space::Grey;
    Type type = Type::Unsigned;
    int bits = 1;     ///< per sample
    int samples = 1;  ///< number of samples that are stored for a pixel; colours come first
    int alpha = -1;   ///< index of the sample of alpha; -1: none
    bool premultiplied = false;
    bool is_planar = false;  ///< whether each sample has its own plane; otherwise samples are interleaved
    std::vector<std::uint16_t> palette = {};               ///< [3 << bits] all reds, then all greens, then all blues
    std::array<float, 3> luma = {0.299F, 0.587F, 0.114F};  ///< YCbCr: weights of red, green and blue
    std::array<float, 6> reference = {0, 255, 128, 255, 128, 255};  ///< YCbCr: codes of black and white

    int colours() const;                          ///< number of samples that state the colour
    std::vector<std::uint16_t> channels() const;  ///< indices of the samples that are used: colours, then alpha
};

/// Function that converts pixels of a row.
/// @param planes  first pixel in the plane of each used channel or, if samples are interleaved, in the only plane
/// @param count   number of pixels
/// @param to      receives the samples of a row source
using TiffRowConverter = std::function<void(std::span<const std::uint8_t* const> planes, std::size_t count, void* to)>;

/// Returns the row source, without size and function, that the converter's rows are for.
RowSource describe_tiff_rows(const TiffPixels& pixels, TiffUse use);

/// Creates a converter. Bits are read from the highest to the lowest; samples of whole bytes have the machine's order.
TiffRowConverter convert_tiff_rows(const TiffPixels& pixels, TiffUse use);

/// Returns the size in bytes of a block of YCbCr with subsampled chroma.
std::size_t chroma_bytes(std::size_t width, std::size_t rows, std::size_t across, std::size_t down);

/// Converts a block of YCbCr with subsampled chroma to three bytes per pixel, by repeating the chroma.
/// @param block   [chroma_bytes()] units of across x down values of Y, one Cb and one Cr, as TIFF 6.0, 21, stores them
/// @param width   pixels in a row; the last unit of a row may exceed it
/// @param to      [rows * width * 3] receives the pixels
void expand_chroma(const std::uint8_t* block, std::size_t width, std::size_t rows, std::size_t across, std::size_t down,
                   std::uint8_t* to);

}  // namespace ccdt::api
