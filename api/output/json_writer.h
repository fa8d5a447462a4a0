#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/output/body.h"
#include "api/output/ink_dots.h"
#include "api/output/map_dots.h"
#include "api/run/options.h"
#include "core/analysis/analysis.h"
#include "core/geometry/faults.h"

namespace ccdt::api {

/// Size of a picture in pixels.
struct PictureSize {
    int width = 0;
    int height = 0;
};

/// What may not be as the sender of a request thinks.
struct Warning {
    std::string field;   ///< JSON Pointer in the request
    std::string detail;  ///< for people
};

/// Members of a JSON answer besides the points.
struct Report {
    std::uint64_t seed = 0;
    double elapsed_ms = 0;
    std::optional<PictureSize> picture;
    std::string_view method = "ccdt";
    std::span<const Repair> repairs = {};    ///< of a polygon; fields are JSON Pointers
    std::optional<DotSize> dots = {};        ///< of a halftone
    std::span<const Warning> warnings = {};  ///< about the request
    std::optional<double> pitch_m = {};      ///< of points on the ground, metres: the square root of what each has
};

/// Writes repairs as an array: `[{"pointer":"/polygon/2","detail":"..."}]`.
std::string write_repairs(std::span<const Repair> repairs);

/// Writes warnings in the same way.
std::string write_warnings(std::span<const Warning> warnings);

/// Writes the JSON answer of /sample and /halftone: of inks with names a list, else the points themselves, also the
/// mesh, if there is one; of dots on both sides of the tonal scale the radius and the side of each, and the rings of
/// the black ground. Tells if a run was stopped, what was repaired, and warnings. Numbers are the shortest that read
/// back to the same double. Same input, same bytes. About 0.1 microseconds a number. Stopped, it ends early, with
/// nothing of use. Like all writers of JSON it throws std::domain_error for a number that is not finite, which would be
/// our own fault.
void write_json(std::span<const InkDots> inks, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes the points of the only ink as GeoJSON (RFC 7946): a Feature whose geometry is a MultiPoint, with what the
/// report tells, but for times, among its properties. Stopped, it ends early, with nothing of use.
void write_feature(std::span<const InkDots> inks, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes the JSON answer of a map of dots: points of one class after the other, and of one feature after the other;
/// of each point the index of its feature, and of its class if these have names; how many points each feature has, with
/// its id and the properties that are carried. Otherwise as write_json().
void write_map_json(const MapOfDots& map, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes the dots of a map as GeoJSON: a FeatureCollection with a Feature for all points of a feature, or of one class
/// in it, whose geometry is a MultiPoint. It has the id of the feature, and its properties that are carried. What the
/// report tells, but for times, is a member of the collection. Stopped, it ends early, with nothing of use.
void write_map_features(const MapOfDots& map, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes points as GeoJSON: a FeatureCollection with a Feature of one Point for each. What the report tells, but for
/// times, is a member of the collection. Of a map each has the properties of its feature that are carried, `feature`,
/// and `feature_id` if the feature has an id. Stopped, it ends early, with nothing of use.
void write_point_features(std::span<const InkDots> inks, const Report& report, Body& body,
                          const std::stop_token& stop = {});
void write_map_point_features(const MapOfDots& map, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes the same Features alone, one to a line.
void write_point_lines(std::span<const InkDots> inks, const Report& report, Body& body,
                       const std::stop_token& stop = {});
void write_map_point_lines(const MapOfDots& map, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes the same lines as a sequence of JSON texts (RFC 8142): each begins with a record separator.
void write_point_sequence(std::span<const InkDots> inks, const Report& report, Body& body,
                          const std::stop_token& stop = {});
void write_map_point_sequence(const MapOfDots& map, const Report& report, Body& body, const std::stop_token& stop = {});

/// Writes the JSON answer of /analyze, the spectrum only if it is asked for. Same input, same bytes.
std::string write_analysis(const Analysis& analysis, bool with_spectrum);

}  // namespace ccdt::api
