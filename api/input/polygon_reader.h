#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/option_reader.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt::api {

/// Polygons as a request gave them, and where in it they stood.
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

    /// Where parts stood: those of one geometry, up to the first of the next.
    struct Source {
        std::size_t first_part = 0;
        Nesting nesting = Nesting::Members;
        std::string coordinates;  ///< JSON Pointer to them, or to the list of rings; not used for Members
    };

    std::vector<PolygonPart> parts;
    std::vector<Source> sources = {{}};  ///< in the order of their parts; never empty
    /// Of each feature of a FeatureCollection, if that is what it was, its first part; of one without, the next one's.
    std::vector<std::size_t> features = {};

    std::size_t corner_count() const;

    bool is_geojson() const { return sources.front().nesting != Nesting::Members; }

    /// Makes the JSON Pointer, in the request, to what Domain::create calls `field`: of a vertex that was added to a
    /// ring (core/globe/region.h) to the ring.
    std::string locate(std::string_view field) const;
};

/// Finds a member that must be there. Errors: Malformed.
Result<Input> require(const Input& object, std::string_view name);

/// Reads `[[x,y],...]`.
/// Errors: Malformed, with a JSON Pointer to what is wrong.
Result<Ring> read_ring(const Input& input);

/// Reads a list of rings.
Result<std::vector<Ring>> read_rings(const Input& input);

/// Tells whether an object is GeoJSON: no request has a member `type`, which every GeoJSON object has.
bool is_geojson(JsonValue value);

/// Reads GeoJSON (RFC 7946): a Polygon, a MultiPolygon, a Feature of one, or a GeometryCollection or
/// FeatureCollection of such, whose parts all together are the polygon. Ordinates after the second, members that are
/// not geometry, and features of a collection that have none are passed over.
/// Errors: Malformed, with a JSON Pointer to what is wrong; Unusable if it is empty.
Result<PolygonInput> read_geometry(const Input& input);

/// Reads areas: a list of rings, each a part, or GeoJSON as above, which may be empty.
/// Errors: as read_geometry().
Result<PolygonInput> read_areas(const Input& input);

/// Checks the number of corners. Errors: LimitExceeded for more than kMaxCorners.
Result<void> check_size(const PolygonInput& polygon);

}  // namespace ccdt::api
