// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "api/decode/decode.h"
#include "api/halftone/halftone_request.h"
#include "api/output/point_drawing.h"
#include "core/base/executor.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/halftone/inks/separation.h"
#include "core/picture/reduction.h"

namespace ccdt::api {

/// A picture that has been separated into inks or channels.
struct SeparatedPicture {
    PictureSize size;     ///< drawn part, in pixels of the file
    CellGrid cells;       ///< cells of the separation, as fine as the dots can show
    Separation inks;      ///< `light` is empty for a single opaque ink, and for channels of light
    double fineness = 0;  ///< result of fineness() for the picture

    /// Returns the area of a cell, in pixels of the file.
    double cell_area() const {
        return static_cast<double>(size.width) * size.height / (static_cast<double>(cells.columns) * cells.rows);
    }
};

/// Decodes a picture and separates it into inks. Where possible, first tries the means of square blocks of pixels.
/// Uses all pixels if the blocks are too coarse. Frees the decoded picture.
/// Errors: as for run_halftone().
Result<SeparatedPicture> separate_picture(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                          const Control& control);

/// Returns the number of pixels of a picture.
double all_pixels(PictureSize size);

/// Returns an error about the image, with the field of the image.
tl::unexpected<Error> about_image(const Error& error, const HalftoneRequest& request);

/// Returns the requested radius, in pixels of the picture.
/// @param scale  output pixels per pixel of the picture
double picture_radius(const HalftoneRequest& request, PictureSize size, double scale);

/// Returns whether the radius of the largest dots follows from the size of the drawing. The number of dots then follows
/// from this radius.
bool has_screen_radius(const HalftoneRequest& request);

/// Returns the radius that follows from the size of the drawing, in pixels of the picture.
double screen_radius(const Canvas& canvas, double fineness);

/// Returns the area that dots draw, in cells: the sum of the coverages of all inks or, for Dots::Both, minority_area().
double drawn_share(const std::vector<std::vector<float>>& coverage, const HalftoneRequest& request, Executor& executor);

}  // namespace ccdt::api
