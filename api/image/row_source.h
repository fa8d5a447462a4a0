// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace ccdt::api {

/// Rows of a picture as its file stores them, and the meaning of their samples.
struct RowSource {
    enum class Sample { Byte, Word, Float };  ///< 8 and 16 bits, with all bits set for the full range; float, up to 1
    enum class Curve { Srgb, Gamma, Linear };

    int width = 0;
    int height = 0;
    int channels = 1;  ///< if at least three, the first three are red, green, blue; else the first is grey
    Sample sample = Sample::Byte;
    int alpha = -1;  ///< its channel; -1: none
    bool premultiplied = false;
    bool has_inks = false;  ///< the channels are the amounts of cyan, magenta, yellow and black
    Curve curve = Curve::Srgb;
    float gamma = 1;      ///< of Curve::Gamma
    int orientation = 1;  ///< EXIF's, 1 to 8; anything else counts as 1, upright
    int step = 1;         ///< number of rows that are best read at once

    /// Reads rows [begin, end), at most `step`, after those that were read before; samples are interleaved.
    /// @returns  false if the file is broken or truncated
    std::function<bool(int begin, int end, void* rows)> read;
};

/// Converts interleaved colours of 16 bits to others.
using WordTransform = std::function<void(const std::uint16_t* from, std::uint16_t* to, std::size_t pixels)>;

/// Converts the colours of a picture to 16 bits of red, green and blue, with its alpha, by which they are not
/// multiplied.
/// @param transform  from red, green, blue, or from inks if the source has inks
RowSource transform_rows(RowSource source, WordTransform transform);

}  // namespace ccdt::api
