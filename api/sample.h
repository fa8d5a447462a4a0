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

/// Grid stretched over the bounding box, the first row at the smallest y.
struct DensityGrid {
    int width = 0;
    int height = 0;
    std::vector<double> values;  ///< [width * height], finite, >= 0
};

/// Picture stretched over the bounding box, the first row at the largest y; dark is dense.
struct DensityImage {
    ImageFile file;
};

/// Corners that the outline of a mask may have.
inline constexpr std::size_t kMostMaskCorners = 100'000;

/// What coordinates are.
enum class Coordinates {
    Plane,   ///< x and y
    LonLat,  ///< longitude and latitude on WGS 84, degrees: points are even on the ground
};

/// What becomes of a polygon that is not valid.
enum class OnInvalid { Repair, Reject };

/// Request to /sample, with its options.
struct SampleRequest {
    std::variant<PolygonInput, Rectangle> domain;
    PolygonInput avoid{{}, {}};     ///< taken from the domain, which is no torus; no parts: nothing
    std::optional<ImageFile> mask;  ///< stretched over the bounding box; its dark half is taken from the domain, too
    double buffer = 0;              ///< least distance from the border, units of the domain or metres on the ground
    OnInvalid on_invalid = OnInvalid::Repair;
    Coordinates coordinates = Coordinates::Plane;                     ///< LonLat of polygons alone
    std::variant<std::monostate, DensityGrid, DensityImage> density;  ///< none: uniform
    Options run;
    const Method* method = &methods().front();
    const PointFormat* format = nullptr;      ///< never null in a request that was parsed
    const MaskFormat* mask_format = nullptr;  ///< a mask is asked for, and no points
    DrawingOptions drawing;
    std::optional<int> width;         ///< of a drawing, in pixels; none: chosen
    std::optional<double> dot;        ///< radius in units of the domain, > 0; none: chosen
    std::optional<PointOrder> order;  ///< none: along a path in drawings of shapes, else as they were placed
    OnStop on_deadline = OnStop::Error;
    std::optional<FeatureList> features;  ///< that points are told by; their parts are those of the polygon
    std::optional<FeatureCounts> counts;  ///< of a map of dots, which has features
    bool is_document = false;             ///< the body is GeoJSON: options came as text

    /// Tells whether points may not lie all over the domain.
    bool has_exclusions() const { return !avoid.parts.empty() || mask || buffer > 0; }

    /// What errors about an option call it.
    std::string field_of(std::string_view option) const;
};

/// Pixels of a drawing whose width is chosen: from dot to dot, if they were evenly spread, and on the longer side.
inline constexpr double kPixelPitch = 8;
inline constexpr double kLeastSide = 512;
inline constexpr double kMostSide = 16'384;

/// Names of the members of a request.
std::vector<std::string_view> sample_options();

/// Reads a request: a JSON object, or a GeoJSON document that options came beside as text.
///
/// @param options  in the order they came, each at most once; none beside a JSON object, which holds them
/// @param accept   the Accept header, empty if there is none; the option `format` wins over it
/// Errors: Malformed for what is not JSON, an unknown or repeated member, a value of the wrong kind or out of
/// range, not exactly one domain; Unsupported for a density image of a format that is not read; LimitExceeded for
/// too many sites, corners or density cells; NotAcceptable. The field is a JSON Pointer, or an option's name.
/// Cheap: whether polygons are valid is left to run_sample, and so is decoding.
Result<SampleRequest> parse_sample(std::string_view body, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits);

/// Builds the domain and the density, distributes, writes the points as the request wants them.
///
/// @param decode   reads a density image
/// @param control  a stop ends it within a pass, with nothing to show for it unless its part is asked for
/// @param timings  filled as far as it came
/// Errors: Unusable for a polygon without area, also after what is avoided is taken from it or what the
/// buffer does not leave, or not valid if such are
/// to be rejected, or a density of zero; those
/// of `decode`; LimitExceeded if a drawing would have more than limits.max_pixels; Stopped. The field is a JSON
/// Pointer. Same request, same bytes, but for `elapsed_ms` in JSON.
Result<Answer> run_sample(const SampleRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodyTaker* taker = nullptr);

}  // namespace ccdt::api
