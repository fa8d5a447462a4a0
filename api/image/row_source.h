// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "api/image/colour_tags.h"

namespace ccdt::api {

/// Rows of a picture as its file stores them, and the meaning of their samples.
struct RowSource {
    enum class Sample { Byte, Word, Float };  ///< type of samples; the float 1.0 corresponds to the largest integer
    enum class Curve { Srgb, Gamma, Linear };
    /// Meaning of the channels without alpha: grey, or red, green and blue; cyan, magenta, yellow and black; CIELAB of
    /// the white D50, with the integers of ICC profiles, version 4.
    enum class Space { Light, Inks, Lab };

    int width = 0;
    int height = 0;
    int channels = 1;  ///< in Space::Light: if at least 3, the first three are red, green and blue; else one is grey
    Sample sample = Sample::Byte;
    Space space = Space::Light;
    int alpha = -1;  ///< channel of alpha; -1: none
    bool premultiplied = false;
    Curve curve = Curve::Srgb;
    float gamma = 1;  ///< exponent of Curve::Gamma
    /// Code points that the coded picture declares. They apply if the file around it declares no colours.
    std::optional<ColourTags::CodePoints> code_points = {};
    int orientation = 1;  ///< orientation of EXIF, 1 to 8; other values are treated as 1, upright
    int step = 1;         ///< preferred number of rows to read at once

    /// Reads rows [begin, end), at most `step`. These rows must follow directly after the rows of the previous call.
    /// Samples are interleaved.
    /// @returns  false if the file is broken or truncated
    std::function<bool(int begin, int end, void* rows)> read;
};

/// Function that converts the interleaved colours of pixels, 16 bits per channel, to another colour space.
using WordTransform = std::function<void(const std::uint16_t* from, std::uint16_t* to, std::size_t pixels)>;

/// Returns a source of the same rows with 16-bit red, green and blue, not premultiplied. Alpha is kept.
/// @param transform  converts the colours of the source, in its space, to red, green and blue
RowSource transform_rows(RowSource source, WordTransform transform);

}  // namespace ccdt::api
