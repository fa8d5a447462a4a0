// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/image/image_codec.h"
#include "api/image/image_header.h"
#include "api/input/domain_reader.h"
#include "api/input/drawing_options.h"
#include "api/input/feature_counts.h"
#include "api/input/feature_list.h"
#include "api/input/point_order.h"
#include "api/input/polygon_reader.h"
#include "api/input/run_options.h"
#include "api/mask.h"
#include "api/method.h"
#include "api/output/body.h"
#include "api/output/formats.h"
#include "api/run/options.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

/// Grid of densities, stretched over the bounding box of the domain. The first row is at the smallest y.
struct DensityGrid {
    int width = 0;
    int height = 0;
    std::vector<double> values;  ///< [width * height], finite, >= 0
};

/// Picture of densities, stretched over the bounding box of the domain. The first row is at the largest y. Dark pixels
/// are dense.
struct DensityImage {
    ImageFile file;
};

/// Maximum number of corners of a mask's outline.
inline constexpr std::size_t kMaxMaskCorners = 100'000;

/// Kind of coordinates.
enum class Coordinates {
    Plane,   ///< x and y
    LonLat,  ///< longitude and latitude on WGS 84, degrees; points are spread evenly on the earth's surface
};

/// Ways to treat invalid polygons.
enum class OnInvalid { Repair, Reject };

/// Request to /sample, with its options.
struct SampleRequest {
    std::variant<PolygonInput, Rectangle> domain;
    PolygonInput avoid{
        {}, {}};  ///< subtracted from the domain, which must then not be a torus; no parts: nothing is subtracted
    std::optional<ImageFile> mask;  ///< stretched over the bounding box; its dark area is subtracted
    double buffer = 0;  ///< minimum distance of points from the border: in units of the domain, or in metres for LonLat
    OnInvalid on_invalid = OnInvalid::Repair;
    Coordinates coordinates = Coordinates::Plane;                     ///< LonLat only with polygons
    std::variant<std::monostate, DensityGrid, DensityImage> density;  ///< none: uniform
    Options run;
    const Method* method = &methods().front();
    const PointFormat* format = nullptr;      ///< never null in a parsed request
    const MaskFormat* mask_format = nullptr;  ///< if not null, the request is for a mask, not for points
    DrawingOptions drawing;
    std::optional<int> width;         ///< width of a drawing in pixels; none: follows from the number of sites
    std::optional<double> dot;        ///< radius in units of the domain, > 0; none: a quarter of the pitch
    std::optional<PointOrder> order;  ///< none: along a path in drawings of shapes, otherwise the order of placement
    OnStop on_deadline = OnStop::Error;
    std::optional<FeatureList> features;  ///< features by which points are grouped; their parts are those of `domain`
    std::optional<FeatureCounts> counts;  ///< counts of a dot map, which also has features
    bool is_document = false;             ///< whether the body is GeoJSON or TopoJSON; options are then given as text

    /// Returns whether parts of the domain are excluded.
    bool has_exclusions() const { return !avoid.parts.empty() || mask || buffer > 0; }

    /// Returns the field of errors about an option: its name or a JSON Pointer.
    std::string field_of(std::string_view option) const;
};

/// Pixel size of a drawing if the request gives no width: the spacing of evenly spread dots, and the limits of the
/// longer side.
inline constexpr double kPixelPitch = 8;
inline constexpr double kMinDrawingSide = 512;
inline constexpr double kMaxDrawingSide = 16'384;

/// Returns the names of the options.
std::vector<std::string_view> sample_options();

/// Reads a request: a JSON object, or a GeoJSON or TopoJSON document whose options are given as text.
///
/// @param options  in the order of the request, without repetition; empty if the body is a JSON object, whose members
///                 are the options
/// @param accept   the Accept header, empty if there is none; the option `format` takes precedence
/// Errors: Malformed for invalid JSON, for an unknown or repeated member, for a value of the wrong type or out of
/// range, and unless exactly one domain is given; Unsupported for a density image in a format that the server does not
/// read; LimitExceeded for too many sites, corners or density cells; NotAcceptable. Error::field is a JSON Pointer or
/// an option's name.
/// Does no expensive work: polygons are validated and images decoded by run_sample().
Result<SampleRequest> parse_sample(std::string_view body, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits);

/// Builds the domain and the density, distributes points, and writes them in the requested format.
///
/// @param decode   reads a density image or a mask
/// @param control  a stop ends the run within a pass; there is no result unless the request accepts a partial one
/// @param timings  receives the times of the completed stages
/// Errors: Unusable if the domain has no area, or none after exclusions and buffer; for an invalid polygon if the
/// request rejects invalid polygons; and for a density that is zero everywhere. Those of `decode`; LimitExceeded if a
/// drawing would have more than limits.max_pixels; Stopped. Error::field is a JSON Pointer. Same request, same bytes,
/// except for `elapsed_ms` in JSON.
Result<Answer> run_sample(const SampleRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodySink* sink = nullptr);

}  // namespace ccdt::api
