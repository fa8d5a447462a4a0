// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/image/image_header.h"
#include "api/input/domain_reader.h"
#include "api/input/drawing_options.h"
#include "api/input/feature_counts.h"
#include "api/input/feature_list.h"
#include "api/input/method.h"
#include "api/input/point_order.h"
#include "api/input/polygon_reader.h"
#include "api/input/reference_system.h"
#include "api/output/formats.h"
#include "api/run/deadline.h"
#include "api/sample/density_input.h"
#include "api/sample/mask/threshold_mask.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// Kind of coordinates.
enum class Coordinates {
    Plane,   ///< x and y
    LonLat,  ///< longitude and latitude on WGS 84, degrees; points are spread evenly on the earth's surface
};

/// Ways to treat invalid polygons.
enum class OnInvalid { Repair, Reject };

/// Region in which points are placed.
struct SampleRegion {
    std::variant<PolygonInput, Rectangle> domain;
    PolygonInput avoid{
        {}, {}};  ///< areas to subtract from the domain, which must not be a torus; no parts: nothing is subtracted
    /// Picture that is stretched over the bounding box of the domain. Its dark area is subtracted.
    std::optional<ImageFile> exclude;
    double buffer = 0;  ///< minimum distance of points from the border: in units of the domain, or in metres for LonLat
    OnInvalid on_invalid = OnInvalid::Repair;
    Coordinates coordinates = Coordinates::Plane;  ///< LonLat requires polygons
    std::optional<ReferenceSystem> system;         ///< as the document names it

    bool is_on_globe() const { return coordinates == Coordinates::LonLat; }

    /// Returns whether parts of the domain are excluded.
    bool has_exclusions() const { return !avoid.parts.empty() || exclude || buffer > 0; }
};

/// Format and look of the answer.
struct SampleOutput {
    const PointFormat* format = nullptr;  ///< never null in a parsed request
    DrawingOptions drawing;
    std::optional<int> width;         ///< width of a drawing in pixels; none: follows from the number of sites
    std::optional<double> dot;        ///< radius in units of the domain, > 0; none: a quarter of the pitch
    std::optional<PointOrder> order;  ///< none: along a path in drawings of shapes, otherwise the order of placement
    std::optional<bool> outlines;     ///< whether drawings show the borders of features; none: see map_style()
    std::optional<bool> legend;       ///< whether drawings of dot maps have a legend; none: see map_style()
    DotTiles tiles;
    bool multipoint = true;  ///< whether GeoJSON groups points into MultiPoints

    /// Returns the variant of a format that `multipoint` asks for.
    const PointFormat& variant_of(const PointFormat& any) const {
        return multipoint || any.single_points == nullptr ? any : *any.single_points;
    }
};

/// Request to /sample, with its options.
struct SampleRequest {
    std::optional<ThresholdMask> threshold_mask;  ///< if set, the request is for this mask instead of points
    SampleRegion region;
    DensityInput density;
    Options run;
    const Method* method = &methods().front();
    OnStop on_deadline = OnStop::Error;
    std::optional<FeatureList> features;  ///< features by which points are grouped; their parts are those of the domain
    std::optional<FeatureCounts> counts;  ///< numbers of points of a dot map; `features` is then set, too
    SampleOutput output;
    bool is_document = false;  ///< whether the body is GeoJSON or TopoJSON; options are then given as text

    /// Returns Error::field for errors about an option: the option's name or a JSON Pointer.
    std::string field_of(std::string_view option) const {
        return is_document ? std::string(option) : pointer_below("", option);
    }

    /// Replaces the name of an option in Error::field by the field of the option.
    Result<void> about_option(Result<void> result) const {
        if (!result) result.error().field = field_of(result.error().field);
        return result;
    }
};

}  // namespace ccdt::api
