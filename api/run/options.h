// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ccdt::api {

/// Limits on a request.
struct Limits {
    std::size_t max_sites = 2'000'000;
    std::size_t max_pixels = 64'000'000;  ///< maximum number of pixels of a decoded picture, a drawing or a raster
    std::size_t max_faces = 4'000'000;    ///< maximum number of triangles into which the faces of a mesh are divided
};

/// Estimated cost of computing an answer.
struct Cost {
    std::size_t memory = 0;  ///< peak memory in bytes, including the answer but not the request
    double seconds = 0;      ///< approximate time on one core of a computer of about 2020
    std::size_t answer = 0;  ///< known lower bound of the size of the answer's body, bytes
    double before = 0;       ///< part of `seconds` before points move, if it is known
    double after = 0;        ///< part of `seconds` after points have moved, if it is known
};

/// Option given as text: a query parameter or a form field.
struct TextOption {
    std::string name;
    std::string value;
};

/// Milliseconds spent in each stage, for Server-Timing.
struct Timings {
    double decode = 0;     ///< decoding of files
    double prepare = 0;    ///< domains, densities and, for halftones, the plan of the drawing
    double optimise = 0;   ///< distribution or analysis of points
    double encode = 0;     ///< writing of the answer
    double processor = 0;  ///< processor time of all threads and of decoders; set by the caller that runs the threads
    /// Maximum number of simultaneous threads, set by the caller that runs them. 0: nothing was computed.
    std::uint32_t threads = 0;

    double before_encoding() const { return decode + prepare + optimise; }
};

/// Size of the dots of a halftone, for clients that draw the dots.
struct DotSize {
    double radius = 0;  ///< pixels of the picture
    double tone = 1;    ///< area that the dots cover, divided by the area that they should cover
};

/// Size of a drawing by a plotter.
struct PlotSize {
    double seconds = 0;  ///< estimated time
    double path_mm = 0;  ///< length of the path, with the pen down and up
    double pen_mm = 0;   ///< width of the widest pen
};

/// Answer to a request, as sent to the client.
struct Answer {
    std::string media_type;
    std::string body;
    bool streamed = false;      ///< whether the body went to a BodySink in pieces
    std::string coding = {};    ///< compression of the body; empty: none
    std::size_t sites = 0;      ///< number of sites that were placed
    std::size_t pixels = 0;     ///< number of pixels that were decoded
    std::string repaired = {};  ///< repairs of polygons, as JSON; empty if there are none or the body lists them
    std::string warnings = {};  ///< warnings about the request, as JSON; empty if there are none or the body lists them
    bool partial = false;       ///< whether the run was stopped early and the result is partial
    bool repeats = true;        ///< whether the same request always gets the same bytes
    std::optional<DotSize> dots = {};   ///< size of the dots of a halftone
    std::optional<PlotSize> plot = {};  ///< size of a drawing by a plotter; caches keep its time only
};

}  // namespace ccdt::api
