// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "api/image/colour_profile.h"
#include "api/image/row_source.h"
#include "core/base/result.h"
#include "core/halftone/inks/overprint.h"
#include "core/picture/picture.h"

namespace ccdt::api {

/// Allocates a plane of `size` values. Called once for each plane of a picture, in the order of the picture's members.
/// Throws if there is not enough memory.
using NewPlane = std::function<std::shared_ptr<float[]>(std::size_t size)>;

/// Parameters of reading a file.
struct Reading {
    Reading(std::size_t most, int side = 1) : max_pixels(most), reduce(side) {}

    static constexpr int kMaxReduced = 4;

    std::size_t max_pixels;  ///< maximum number of pixels in the file; checked before pixels are read
    /// Factor, 1 to kMaxReduced, by which the sides of a picture are divided. Each square of `reduce` x `reduce`
    /// pixels becomes one pixel with the mean light of the square. A picture that is not opaque or not divisible into
    /// whole squares is not reduced.
    int reduce;
    /// Whether the file is a TIFF whose pages are the layers of a stack, which are then read one below the other.
    /// Samples of these pages are not converted to light.
    bool is_stack = false;
    /// Ground on which partly transparent pixels are shown by displayed_light(); they become opaque. Pixels with an
    /// alpha of 0 stay transparent. None: alpha and colours are read as they are stored.
    std::optional<Light> ground = {};
    /// Receives the share of the rows that are read, in (0, 1), after each group of rows but the last; may be empty.
    std::function<void(double)> progress = {};
};

/// Allocates a plane in the memory of this process.
std::shared_ptr<float[]> new_plane(std::size_t size);

/// Reads all rows of a picture and converts their samples to linear light with the primaries of sRGB.
///
/// @tparam AnyPicture  Picture or ColourPicture
/// @param conversion   gives the curves and the matrix; null: those of the source
/// @param reading      `reduce`, `ground` and `progress` are used
/// Errors: Unusable if the source cannot be read to its end.
template <class AnyPicture>
Result<AnyPicture> read_picture(const RowSource& source, const ColourConversion* conversion, const Reading& reading,
                                const NewPlane& make_plane = new_plane);

}  // namespace ccdt::api
