// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/image/image_codec.h"
#include "api/image/image_header.h"
#include "api/input/drawing_options.h"
#include "api/input/palette.h"
#include "api/input/picture_options.h"
#include "api/input/run_options.h"
#include "api/output/formats.h"
#include "api/run/options.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/picture/levels.h"
#include "core/picture/tone.h"

namespace ccdt::api {

/// Radius of dots.
struct DotRadius {
    double length = 0;  ///< > 0
    /// Whether the length is in millimetres, which requires the option width_mm. If not, it is in pixels of the output.
    bool millimetres = false;
};

/// Shapes of the dots of a halftone.
enum class Dots {
    Both,   ///< areas of ink, drawn by one field: dots in the light, holes in the dark, a net in the middle
    Ink,    ///< discs of ink on paper
    Paper,  ///< light discs, which draw the light parts of the picture, on black
};

/// Request to /halftone, with its options.
struct HalftoneRequest {
    ImageFile image;
    std::string image_field;           ///< Error::field of errors about the image; empty unless the body is JSON
    std::optional<std::size_t> sites;  ///< none: chosen by the server
    std::optional<double>
        minutes;  ///< maximum drawing time of a plotter; limits the number of sites that the server chooses
    Options run;  ///< seed, iterations, passes, quality; with Dots::Both, that of quality_of_sites()
    std::optional<double> scale;   ///< output pixels per input pixel; none: chosen by the server
    std::optional<int> width;      ///< pixels of the drawing; cannot be combined with `scale`
    std::optional<int> height;     ///< pixels of the drawing; cannot be combined with `scale`
    Fit fit = Fit::Contain;        ///< Cover requires width and height
    Focus gravity;                 ///< point of the picture that Cover shows as near to the middle as possible
    bool on_screen = false;        ///< whether the drawing is for a screen; its size then determines the number of dots
    std::optional<DotRadius> dot;  ///< none: chosen by the server
    double detail = 0.7;           ///< strength of sharpening, 0 to 1, as in DotRequest; 0: no sharpening
    AlphaMixing alpha = AlphaMixing::Display;  ///< how partly transparent pixels show the paper
    Levels levels;                             ///< applied to the picture before all other steps
    bool antialias = false;
    bool may_be_scaled = false;  ///< whether browsers are likely to scale the drawing; true if it is for a
                                 ///< screen and the request gives neither its size nor `antialias`
    Dots dots = Dots::Ink;       ///< Paper requires a single opaque ink
    Tone tone = Tone::Linear;
    Palette palette;
    const PointFormat* format = nullptr;  ///< never null in a parsed request
    DrawingOptions drawing;
    OnStop on_deadline = OnStop::Error;

    /// Returns Error::field for errors about an option: the option's name or a JSON Pointer.
    std::string field_of(std::string_view option) const;
};

/// Replaces the name of an option in Error::field by the field of the option in a request.
inline Result<void> about_option(const HalftoneRequest& request, Result<void> result) {
    if (!result) result.error().field = request.field_of(result.error().field);
    return result;
}

}  // namespace ccdt::api
