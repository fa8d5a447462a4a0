// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/output/body.h"
#include "api/output/point_set.h"
#include "api/run/options.h"
#include "core/geometry/faults.h"
#include "core/points/analysis/analysis.h"

namespace ccdt::api {

/// Size of a picture in pixels.
struct PictureSize {
    int width = 0;
    int height = 0;
};

/// Remark about a part of a request that may not mean what its sender intended.
struct Warning {
    std::string field;   ///< JSON Pointer in the request
    std::string detail;  ///< readable text
};

/// Members of a JSON answer other than the points.
struct Report {
    std::uint64_t seed = 0;
    double elapsed_ms = 0;
    std::optional<PictureSize> picture;
    std::string_view method = "ccdt";
    std::span<const Repair> repairs = {};    ///< repairs of polygons; fields are JSON Pointers
    std::optional<DotSize> dots = {};        ///< size of the dots of a halftone
    std::span<const Warning> warnings = {};  ///< remarks about the request
    std::optional<double> pitch_m = {};      ///< for points on the globe: square root of the area per point, metres
};

/// Writes repairs as an array: `[{"pointer":"/polygon/2","detail":"..."}]`.
std::string write_repairs(std::span<const Repair> repairs);

/// Writes warnings as an array, in the form of write_repairs().
std::string write_warnings(std::span<const Warning> warnings);

/// Writes the JSON answer of /sample and /halftone. If inks have names, the answer has a list of inks with their
/// points. Otherwise it has a list of points, and the mesh if there is one. A drawing by one field also has the
/// outlines of the ink or, if inks have names, a list of inks with their outlines. The answer also reports an early
/// stop, repairs and warnings.
///
/// If points are grouped by features, the points of all classes are one list, sorted by class, and within a class by
/// feature. Each point has the index of its feature, and the index of its class if classes have names. The answer has a
/// list of features, with the number of points, the id, and the carried properties of each feature. These are the
/// properties that the request chose (PointSet::properties).
///
/// Numbers have the fewest digits that read back to the same double. The same input gives the same bytes. Takes about
/// 0.1 microseconds per number. After a stop, the output is incomplete. Like all writers of JSON, this function throws
/// std::domain_error for a number that is not finite, which would be a bug in this project.
void write_json(const PointSet& points, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes points as GeoJSON (RFC 7946), with the members of the report, except for times. Points that are not grouped
/// by features must have a single layer (see PointSet); they are written as a Feature whose geometry is a MultiPoint.
/// Grouped points are written as a FeatureCollection. It has a Feature, with a MultiPoint, for each class in each
/// feature of the request that has points of this class. Such a Feature has the id and the carried properties (see
/// write_json()) of that feature of the request. After a stop, the output is incomplete.
void write_geojson(const PointSet& points, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes points as GeoJSON: a FeatureCollection with a Feature for each point. The report, except for times, is in
/// members of the collection. If points are grouped, each Feature has the carried properties as its properties, and in
/// addition `feature`, the index of the feature in the request, and `feature_id` if that feature has an id. After a
/// stop, the output is incomplete.
void write_point_features(const PointSet& points, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes only the Features of write_point_features(), one per line.
void write_point_lines(const PointSet& points, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes the lines of write_point_lines() as a sequence of JSON texts (RFC 8142), each after a record separator.
void write_point_sequence(const PointSet& points, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes the JSON answer of /analyze, with the spectrum if it was requested. The same input gives the same bytes.
std::string write_analysis(const Analysis& analysis, bool with_spectrum);

}  // namespace ccdt::api
