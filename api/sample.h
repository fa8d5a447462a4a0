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

/// Density grid stretched over the bounding box; the first row is at the smallest y.
struct DensityGrid {
    int width = 0;
    int height = 0;
    std::vector<double> values;  ///< [width * height], finite, >= 0
};

/// Picture stretched over the bounding box; the first row is at the largest y, and dark is dense.
struct DensityImage {
    ImageFile file;
};

/// Maximum number of corners of a mask's outline.
inline constexpr std::size_t kMostMaskCorners = 100'000;

/// Kind of coordinates.
enum class Coordinates {
    Plane,   ///< x and y
    LonLat,  ///< longitude and latitude on WGS 84, degrees; points are spread evenly on the ground
};

/// Treatment of invalid polygons.
enum class OnInvalid { Repair, Reject };

/// Request to /sample, with its options.
struct SampleRequest {
    std::variant<PolygonInput, Rectangle> domain;
    PolygonInput avoid{{}, {}};     ///< subtracted from the domain, which is no torus; no parts: nothing
    std::optional<ImageFile> mask;  ///< stretched over the bounding box; its dark area is subtracted, too
    double buffer = 0;              ///< least distance from the border, in units of the domain or metres on the ground
    OnInvalid on_invalid = OnInvalid::Repair;
    Coordinates coordinates = Coordinates::Plane;                     ///< LonLat only with polygons
    std::variant<std::monostate, DensityGrid, DensityImage> density;  ///< none: uniform
    Options run;
    const Method* method = &methods().front();
    const PointFormat* format = nullptr;      ///< never null in a parsed request
    const MaskFormat* mask_format = nullptr;  ///< not null: the request is for a mask, not for points
    DrawingOptions drawing;
    std::optional<int> width;         ///< of a drawing, in pixels; none: follows from the number of sites
    std::optional<double> dot;        ///< radius in units of the domain, > 0; none: a quarter of the pitch
    std::optional<PointOrder> order;  ///< none: path in drawings of shapes, otherwise the order of placement
    OnStop on_deadline = OnStop::Error;
    std::optional<FeatureList> features;  ///< that points are grouped by; their parts are those of the polygon
    std::optional<FeatureCounts> counts;  ///< of a dot map, which has features
    bool is_document = false;             ///< the body is GeoJSON or TopoJSON, and the options came as text

    /// Returns whether parts of the domain are excluded.
    bool has_exclusions() const { return !avoid.parts.empty() || mask || buffer > 0; }

    /// Returns the field of errors about an option: its name or a JSON Pointer.
    std::string field_of(std::string_view option) const;
};

/// Size in pixels of a drawing without a given width: pitch of evenly spread dots, and limits of the longer side.
inline constexpr double kPixelPitch = 8;
inline constexpr double kLeastSide = 512;
inline constexpr double kMostSide = 16'384;

/// Returns the names of the members of a request.
std::vector<std::string_view> sample_options();

/// Reads a request: a JSON object, or a GeoJSON or TopoJSON document with options beside it as text.
///
/// @param options  in the order in which they came, each at most once; empty with a JSON object, which holds its
///                 options
/// @param accept   the Accept header, empty if there is none; the option `format` takes precedence
/// Errors: Malformed for invalid JSON, an unknown or repeated member, a value of the wrong type or out of range, or
/// unless exactly one domain is given; Unsupported for a density image in a format that the server does not read;
/// LimitExceeded for too many sites, corners or density cells; NotAcceptable. The field is a JSON Pointer or an
/// option's name.
/// Does no expensive work: run_sample() validates polygons and decodes images.
Result<SampleRequest> parse_sample(std::string_view body, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits);

/// Builds the domain and the density, distributes points, and writes them in the requested format.
///
/// @param decode   reads a density image or a mask
/// @param control  a stop ends the run within a pass, without a result unless the request accepts a partial one
/// @param timings  filled as far as the run gets
/// Errors: Unusable for a domain without area, also after exclusions and buffer are subtracted, for an invalid polygon
/// if the request rejects these, and for a density of zero; those of `decode`; LimitExceeded if a drawing would have
/// more than limits.max_pixels; Stopped. The field is a JSON Pointer. Same request, same bytes, except for `elapsed_ms`
/// in JSON.
Result<Answer> run_sample(const SampleRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodyTaker* taker = nullptr);

}  // namespace ccdt::api
