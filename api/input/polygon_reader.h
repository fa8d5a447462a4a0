// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/option_reader.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt::api {

/// Polygons of a request, and their locations in it.
struct PolygonInput {
    /// Nesting of positions in the request.
    enum class Nesting {
        Members,             ///< /polygon/vertex and /holes/ring/vertex
        Rings,               ///< .../part/vertex
        Polygon,             ///< .../coordinates/ring/vertex
        MultiPolygon,        ///< .../coordinates/part/ring/vertex
        ArcsOfPolygon,       ///< .../arcs/ring, of TopoJSON
        ArcsOfMultiPolygon,  ///< .../arcs/part/ring
    };

    static constexpr std::size_t kMaxCorners = 1'000'000;

    /// Location of the parts of one geometry; its last part is before the first one of the next source.
    struct Source {
        std::size_t first_part = 0;
        Nesting nesting = Nesting::Members;
        std::string coordinates;  ///< JSON Pointer to them, or to the list of rings; not used for Members
    };

    std::vector<PolygonPart> parts;
    std::vector<Source> sources = {{}};  ///< in the order of their parts; never empty
    /// Index of the first part of each feature of a FeatureCollection, or of the next one's if a feature has none.
    std::vector<std::size_t> features = {};

    std::size_t corner_count() const;

    bool is_geojson() const { return sources.front().nesting != Nesting::Members; }

    /// Returns the JSON Pointer, in the request, to what Domain::create calls `field`. For a vertex that was added to a
    /// ring (core/globe/region.h), it points to the ring.
    std::string locate(std::string_view field) const;
};

/// Finds a member that must exist. Errors: Malformed.
Result<Input> require(const Input& object, std::string_view name);

/// Reads `[[x,y],...]`.
/// Errors: Malformed, with a JSON Pointer to the faulty value.
Result<Ring> read_ring(const Input& input);

/// Reads a list of rings.
Result<std::vector<Ring>> read_rings(const Input& input);

/// Returns whether a value is GeoJSON: every GeoJSON object has a member `type`, and no request has one.
bool is_geojson(JsonValue value);

/// Reads GeoJSON (RFC 7946): a Polygon, a MultiPolygon, a Feature of one, or a GeometryCollection or FeatureCollection
/// of such; all their parts together form the polygon. Ignores ordinates after the second, members that are not
/// geometry, and features of a collection without geometry.
/// Errors: Malformed, with a JSON Pointer to the faulty value; Unusable if there is no polygon.
Result<PolygonInput> read_geometry(const Input& input);

/// Reads areas: a list of rings, each of which is a part, or GeoJSON as above, which may be empty.
/// Errors: those of read_geometry().
Result<PolygonInput> read_areas(const Input& input);

/// Checks the number of corners. Errors: LimitExceeded for more than kMaxCorners.
Result<void> check_size(const PolygonInput& polygon);

}  // namespace ccdt::api
