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
#include "api/input/run_options.h"
#include "api/output/body.h"
#include "api/output/formats.h"
#include "api/run/options.h"
#include "core/ccdt/ccdt.h"
#include "core/halftone/levels.h"
#include "core/halftone/tone.h"
#include "core/result.h"

namespace ccdt::api {

/// Radius of dots.
struct DotRadius {
    double length = 0;         ///< > 0
    bool millimetres = false;  ///< as the drawing's width_mm has them; else pixels of the output
};

/// Sides of the tonal scale on which dots are drawn.
enum class Dots {
    Both,   ///< ink on white ground where the picture is light, bare paper on black ground where it is dark
    Ink,    ///< ink on paper
    Paper,  ///< the light instead of the dark, on black
};

/// Ways to fit a picture into a drawing whose width and height are both given.
enum class Fit {
    Contain,  ///< all of it is drawn, as large as fits within both sides
    Cover,    ///< its middle is drawn, with just these sides
};

/// Request to /halftone, with its options.
struct HalftoneRequest {
    ImageFile image;
    std::string image_field;           ///< for Error::field; empty if it is the body
    std::optional<std::size_t> sites;  ///< none: chosen from the image
    std::optional<double> minutes;     ///< that a plotter may take: bounds the sites that are chosen
    Options run;                       ///< seed, iterations, passes
    std::optional<double> scale;       ///< output pixels per input pixel; none: chosen
    std::optional<int> width;          ///< of the drawing, pixels; instead of a scale
    std::optional<int> height;         ///< of the drawing, pixels; instead of a scale
    Fit fit = Fit::Contain;            ///< Cover only with width and height
    bool on_screen = false;            ///< the drawing is for a screen: its size decides on the number of dots
    std::optional<DotRadius> dot;      ///< none: such that the tone is right
    double detail = 0.7;               ///< of DotWish; 0 unless given where dots follow the density alone
    Levels levels;                     ///< of the picture, before anything else is made of it
    bool antialias = false;
    Dots dots = Dots::Ink;  ///< others than Ink only of an ink that covers
    Tone tone = Tone::Linear;
    Palette palette;
    const PointFormat* format = nullptr;  ///< never null in a request that was parsed
    DrawingOptions drawing;
    OnStop on_deadline = OnStop::Error;

    /// Returns the field of an option, for errors about one that was not given.
    std::string field_of(std::string_view option) const;
};

/// Names of the options that may come as text.
std::vector<std::string_view> halftone_options();

/// Reads a request whose image is the body, or a part of a form; options come as text.
///
/// @param image    the file's bytes, which must outlive the request
/// @param options  in the order they came
/// @param accept   the Accept header, empty if there is none; the option `format` wins over it
/// Errors: Malformed for an option that is unknown, repeated or out of range, or no image; Unsupported for an
/// image of a format that is not read; LimitExceeded for too many sites; NotAcceptable if neither of the formats
/// is accepted. The field is the option's name. Cheap: the image is not decoded.
Result<HalftoneRequest> parse_halftone(std::string_view image, const std::vector<TextOption>& options,
                                       std::string_view accept, const Limits& limits);

/// Reads a request whose body is a JSON object, with the member `image` in base64 or as a data: URI.
///
/// @param options  that came in the query besides; they must not repeat a member
/// Errors: as above, and those of JsonDocument::parse. The field of a member is its JSON Pointer.
Result<HalftoneRequest> parse_halftone_json(std::string_view body, const std::vector<TextOption>& options,
                                            std::string_view accept, const Limits& limits);

/// Decodes, distributes, draws, encodes.
///
/// @param decode   reads the picture
/// @param control  a stop ends it within a pass, with nothing to show for it unless its part is asked for
/// @param timings  filled as far as it came
/// @returns        a file of the format that the request wants
/// Errors: those of `decode`; Unusable for a picture without ink; LimitExceeded if the output would have more
/// than limits.max_pixels, or more than WebP holds; Stopped. Same request, same bytes, but for `elapsed_ms` in JSON.
Result<Answer> run_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                            const Control& control, Timings& timings, BodyTaker* taker = nullptr);

}  // namespace ccdt::api
