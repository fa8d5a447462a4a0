// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "api/decode/decode.h"
#include "api/halftone/halftone_input.h"
#include "api/halftone/halftone_plan.h"
#include "api/halftone/halftone_request.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// Returns the names of the options. Each option may be given as text.
std::vector<std::string_view> halftone_options();

/// Parses the options of a request.
///
/// @param input   image and options; the bytes of the image must outlive the request
/// @param accept  the Accept header, empty if there is none; the option `format` takes precedence
/// Errors: Malformed for an option that is unknown, repeated or out of range, and for a missing image; Unsupported for
/// an image in a format that the server does not read; LimitExceeded for too many sites; NotAcceptable if the client
/// accepts none of the formats. Error::field is the option's name, or a JSON Pointer to the member of the body. Does no
/// expensive work: the image is not decoded.
Result<HalftoneRequest> parse_halftone(const HalftoneInput& input, std::string_view accept, const Limits& limits);

/// A halftone whose dots are placed. It can be written in several formats.
struct PlacedHalftone {
    HalftonePlan plan;
    std::vector<Distribution> dots;
    double elapsed = 0;  ///< computing time so far, milliseconds
};

/// Decodes the picture and distributes the dots.
/// Errors: those of run_halftone(), except for errors of writing.
Result<PlacedHalftone> place_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                      const Control& control, Timings& timings);

/// Writes placed dots in the requested format, or in another one. The dots and the size of the drawing are those of the
/// request in any case.
///
/// @param placed  result of place_halftone() for `request`
/// @param sink    as for run_halftone()
/// Errors: those of writing in run_halftone(); Malformed if the format needs an option that the request does not give,
/// or cannot draw holes; LimitExceeded if the drawing would be too large.
Result<Answer> write_answer(const HalftoneRequest& request, const PlacedHalftone& placed, const PointFormat& format,
                            const Limits& limits, const Control& control, Timings& timings, BodySink* sink = nullptr);

/// Decodes the picture, distributes the dots, and writes them in the requested format.
///
/// @param control  a requested stop ends the run within one pass over the sites
/// @param sink     receives the body in pieces if the body is larger than Body::kMaxInMemory; null: the answer contains
///                 the whole body
/// @returns        the answer; without its body if the sink received the body
/// Errors: those of `decode`; Unusable if dots have nothing to draw in the picture; LimitExceeded if the output would
/// have more than limits.max_pixels, or a side longer than the format allows; Stopped, unless the request accepts a
/// partial result. The same request gives the same bytes, except for `elapsed_ms` in JSON.
Result<Answer> run_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                            const Control& control, Timings& timings, BodySink* sink = nullptr);

}  // namespace ccdt::api
