// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "api/decode/decode.h"
#include "api/json/json_document.h"
#include "api/output/body.h"
#include "api/run/deadline.h"
#include "api/run/options.h"
#include "api/sample/density_input.h"
#include "api/sample/pixels/pixel_formats.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/density/density.h"
#include "core/dither/frame.h"

namespace ccdt::api {

/// Request to /sample with a domain of the type `pixels`: a set with an exact number of pixels of a raster. Pixels are
/// counted from the top left one, [0, 0].
struct PixelRequest {
    FrameSize raster;
    std::size_t sites = 0;
    DensityInput density;
    std::vector<CellBlock> included;  ///< pixels that are always in the set, within the raster; blocks may overlap
    std::string_view including = {};  ///< JSON Pointer to `include`, or to `calibration` if only that is given
    std::uint64_t seed = 0;
    const PixelFormat* format = nullptr;  ///< never null in a parsed request
    OnStop on_deadline = OnStop::Error;   ///< a partial answer is spread less evenly
};

/// Returns the names of the options.
std::vector<std::string_view> pixel_options();

/// Whether a body of /sample has a domain of the type `pixels`.
bool asks_for_pixels(JsonValue root);

/// Reads a request whose body has a domain of the type `pixels`.
/// @param options  options that are given as text; must be empty
/// Errors: as for parse_sample(). Options that apply only to points are Malformed. LimitExceeded for a raster of more
/// than limits.max_pixels; Unusable if there are more sites than pixels, or if an included pixel is outside the raster.
Result<PixelRequest> parse_pixels(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                  const Limits& limits);

/// Chooses the pixels and writes them in the requested format.
/// @param sink  as for run_sample()
/// Errors: those of `decode`; Unusable if more pixels are included than there are sites, or if the density is positive
/// in fewer pixels than there are sites; Stopped, unless the request accepts a partial result and the stop comes after
/// decoding. Same request, same bytes.
Result<Answer> run_pixels(const PixelRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodySink* sink = nullptr);

/// Estimates the cost of run_pixels().
Cost cost_of(const PixelRequest& request, const Limits& limits);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const PixelRequest& request);

}  // namespace ccdt::api
