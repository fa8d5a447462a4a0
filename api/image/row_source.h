#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace ccdt::api {

/// Rows of a picture as its file stores them, and what their numbers stand for.
struct RowSource {
    enum class Sample { Byte, Word, Float };  ///< 8 and 16 bits, of which all set is the full range; float, up to 1
    enum class Curve { Srgb, Gamma, Linear };

    int width = 0;
    int height = 0;
    int channels = 1;  ///< from three on, the first three are red, green, blue; else the first is grey
    Sample sample = Sample::Byte;
    int alpha = -1;  ///< its channel; -1: none
    bool premultiplied = false;
    bool has_inks = false;  ///< the channels are cyan, magenta, yellow, black: how much of each is printed
    Curve curve = Curve::Srgb;
    float gamma = 1;      ///< of Curve::Gamma
    int orientation = 1;  ///< EXIF's, 1 to 8; anything else counts as 1, upright
    int step = 1;         ///< rows that are best read at once

    /// Reads rows [begin, end), of a step or less, going on where it was; samples lie side by side.
    /// @returns  false if the file is broken or cut short
    std::function<bool(int begin, int end, void* rows)> read;
};

/// Turns colours into others, of 16 bits, side by side.
using WordTransform = std::function<void(const std::uint16_t* from, std::uint16_t* to, std::size_t pixels)>;

/// Shows the same picture in other colours: of 16 bits, red, green, blue, and its alpha, by which they are not
/// multiplied.
/// @param transform  from red, green, blue, or from inks where the source has inks
RowSource transform_rows(RowSource source, WordTransform transform);

}  // namespace ccdt::api
