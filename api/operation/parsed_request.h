// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "api/decode/decode.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// A parsed, valid request of any kind. May point into the body that was parsed.
class ParsedRequest {
public:
    virtual ~ParsedRequest() = default;

    /// Returns the name of the format of the answer.
    virtual std::string_view format() const = 0;

    /// Returns the cost of computing the answer, including the memory of the request itself.
    virtual Cost cost() const = 0;

    /// Returns an upper estimate of the size of the answer's body in bytes. Unlike `Cost::answer`, it may be far too
    /// large.
    virtual std::size_t largest_answer() const = 0;

    /// Whether the request accepts a partial answer when the computation is stopped.
    virtual bool accepts_partial() const = 0;

    /// Computes the answer.
    ///
    /// When `control` requests a stop, the computation ends within one pass over the sites. The result is then the
    /// error Stopped or, if the request allows it, a partial answer.
    /// @param sink  receives a large body in pieces; null: the body is returned whole
    /// Errors: those of the kind of request. After an error, delivered pieces of the body must be discarded. `timings`
    /// receives the durations of all stages that ran.
    virtual Result<Answer> run(const Decode& decode, const Control& control, Timings& timings,
                               BodySink* sink) const = 0;
};
using ParsedPointer = std::unique_ptr<const ParsedRequest>;

/// Kinds of bodies of requests for halftones.
enum class HalftoneBody {
    Picture,  ///< the file of a picture
    Json,     ///< a JSON object with the picture as base64, and options
};

/// Parses a request for a halftone or for the pixels of a device.
/// @param options  options in addition to those of the body
/// @param accept   accepted media types, as in an HTTP header; used if no option gives the format
/// Errors: those of parse_halftone() and parse_device().
Result<ParsedPointer> parse_halftone_request(std::string_view body, HalftoneBody kind,
                                             const std::vector<TextOption>& options, std::string_view accept,
                                             const Limits& limits);

/// Parses a request for points, for a threshold mask, or for pixels of a raster. The body is JSON, a mesh, which
/// recognise_surface() recognises, or a file of voxels, which is_voxel_file() recognises. The other parameters are
/// those of parse_halftone_request().
/// @param media_type  media type of the body, in lower case and without parameters; empty: unknown
/// Errors: those of parse_sample(), parse_pixels(), parse_surface(), parse_volume() and parse_solid().
Result<ParsedPointer> parse_sample_request(std::string_view body, const std::vector<TextOption>& options,
                                           std::string_view accept, const Limits& limits,
                                           std::string_view media_type = {});

/// Parses a request for an analysis of points. The body is JSON without further options, or a mesh; the option `points`
/// then has the points on its surface. The other parameters are those of parse_sample_request(). Errors: those of
/// parse_analyze() and parse_surface_analyze(); Malformed for options beside a body that is not a mesh.
Result<ParsedPointer> parse_analyze_request(std::string_view body, const std::vector<TextOption>& options,
                                            std::string_view accept, const Limits& limits,
                                            std::string_view media_type = {});

}  // namespace ccdt::api
