// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/option_reader.h"
#include "core/base/result.h"
#include "core/geometry/domain.h"

namespace ccdt::api {

/// Polygons of a request, and their locations in the request.
struct PolygonInput {
    /// Nesting of arrays in the request, which gives the JSON Pointer to a vertex or, in TopoJSON, to a ring.
    enum class Nesting {
        Members,             ///< /polygon/vertex and /holes/ring/vertex
        Rings,               ///< .../part/vertex
        Polygon,             ///< .../coordinates/ring/vertex
        MultiPolygon,        ///< .../coordinates/part/ring/vertex
        ArcsOfPolygon,       ///< .../arcs/ring, of TopoJSON
        ArcsOfMultiPolygon,  ///< .../arcs/part/ring
    };

    static constexpr std::size_t kMaxCorners = 1'000'000;

    /// Location of one geometry, or of some of its parts. The parts are those from `first_part` up to the first part of
    /// the next source.
    struct Source {
        Nesting nesting = Nesting::Members;
        std::string coordinates =
            {};  ///< JSON Pointer to the coordinates or to the list of rings; not used for Members
        std::size_t first_part = 0;
        std::size_t first_index = 0;  ///< index of the first part in the geometry

        std::size_t index_of(std::size_t part) const { return part - first_part + first_index; }
    };

    /// Geometries of one kind that have no polygon, and are left out.
    struct Omitted {
        std::string_view kind;  ///< `null`, `empty`, or the type of points or lines
        std::string first;      ///< JSON Pointer to the first of these geometries
        std::size_t count = 0;
    };

    std::vector<PolygonPart> parts;
    std::vector<Source> sources = {{}};  ///< in the order of their parts; never empty
    /// [features] index of the first part of each feature of a FeatureCollection. A feature without parts has the index
    /// of the first part that follows.
    std::vector<std::size_t> features = {};
    std::vector<Omitted> omitted = {};

    /// Appends the parts of a geometry, except for parts whose outer ring is empty.
    /// @param pointer  JSON Pointer to the geometry
    void append(const Source& source, std::vector<PolygonPart> geometry, const std::string& pointer);

    /// Counts a geometry that has no polygon. Returns false for a kind that is none of those of Omitted.
    bool omit(std::string_view kind, const std::string& pointer);

    /// Checks that there is a polygon. Errors: Malformed if there are points or lines instead; otherwise Unusable.
    Result<void> check(const Input& input) const;

    std::size_t corner_count() const;

    /// Whether the polygons are GeoJSON or TopoJSON, instead of the members `polygon` and `holes`.
    bool is_geojson() const { return sources.front().nesting != Nesting::Members; }

    /// Converts the field of an error or a repair of Domain to a JSON Pointer in the request. unrolled() in
    /// core/ccdt/globe/region.h can add vertices that are not in the request. For such a vertex, the result points to
    /// its ring.
    std::string pointer_to(std::string_view field) const;
};

/// Finds a member that must exist. Errors: Malformed.
Result<Input> require(const Input& object, std::string_view name);

/// Reads `[[x,y],...]`.
/// Errors: Malformed, with a JSON Pointer to the faulty value.
Result<Ring> read_ring(const Input& input);

/// Returns the polygons of a request: those of the member `geometry` or, without it, `polygon` with its holes.
PolygonInput polygons_of(std::optional<PolygonInput> geometry, std::optional<Ring> polygon,
                         std::optional<std::vector<Ring>> holes);

/// Reads a list of rings.
Result<std::vector<Ring>> read_rings(const Input& input);

/// Returns whether a value is GeoJSON: GeoJSON objects have a member `type`, which no request has.
bool is_geojson(JsonValue value);

/// Reads GeoJSON (RFC 7946): a Polygon, a MultiPolygon, a Feature with one of these, or a GeometryCollection or
/// FeatureCollection of them. All their parts together form the polygon. Ignores ordinates after the second, and
/// members that are not geometry. Leaves out geometries that are null, empty, points or lines, and counts them. Errors:
/// Malformed, with a JSON Pointer to the faulty value; those of PolygonInput::check().
Result<PolygonInput> read_geometry(const Input& input);

/// Reads areas: a list of rings, each of which becomes a part, or GeoJSON as in read_geometry(). The result may have no
/// parts. Errors: those of read_geometry().
Result<PolygonInput> read_areas(const Input& input);

/// Checks the number of corners. Errors: LimitExceeded for more than kMaxCorners.
Result<void> check_size(const PolygonInput& polygon);

}  // namespace ccdt::api
