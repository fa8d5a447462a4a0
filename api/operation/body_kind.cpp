// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/operation/body_kind.h"

#include "api/image/image_header.h"
#include "api/input/npy_reader.h"
#include "api/input/polygon_reader.h"
#include "api/input/topology_reader.h"
#include "api/surface/surface_header.h"
#include "api/text/byte_order_mark.h"
#include "api/text/file_kind.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kGeoJson = "GeoJSON", kTopoJson = "TopoJSON";

constexpr std::string_view kOfSample =
    "options in JSON, a map (GeoJSON, TopoJSON or a zipped shapefile), a mesh (STL, OBJ, PLY, OFF, GLB or glTF), "
    "voxels (NPY or TIFF), and with candidates=body points (CSV, GeoJSON, NPY or PLY)";

/// Whether a body may be meant as JSON. JSON in UTF-16 is not.
bool may_be_json(std::string_view body) {
    constexpr std::size_t kFirst = 4;
    return begins_like_json(without_byte_order_mark(body), " \t\r\n\x1E") &&
           body.substr(0, kFirst).find('\0') == body.npos;
}

std::string kind_of_whole_body(std::string_view body) {
    if (const auto image = recognise_image(body)) return "a picture (" + std::string(name_of(*image)) + ')';
    if (const auto mesh = recognise_surface(body)) return "a mesh (" + std::string(name_of(*mesh)) + ')';
    if (is_npy(body)) return "a NumPy array";
    if (may_be_json(body)) return "JSON";
    const std::string_view kind = kind_of_file(body);
    return kind.empty() ? "binary data of an unknown kind" : std::string(kind);
}

}  // namespace

bool is_stripped(std::string_view body) {
    constexpr std::size_t kShortest = 32;
    return body.size() >= kShortest && body.find_first_of("\0\r\n"sv) == body.npos && !is_text(body);
}

std::string kind_of_body(std::string_view body) {
    std::string kind = kind_of_whole_body(body);
    if (is_stripped(body))
        kind += " without its line ends and zeros, which curl -d removes from a file (use --data-binary)";
    return kind;
}

std::string_view kind_of_json(JsonValue root) {
    if (is_topology(root)) return kTopoJson;
    if (is_geojson(root)) return kGeoJson;
    if (root.is_array()) {
        const bool has_geojson = root.size() > 0 && is_geojson(*root.begin());
        return has_geojson ? "a list of GeoJSON objects, which must be the features of a FeatureCollection" : "";
    }
    const auto has = [root](std::string_view name) { return root.is_object() && root.find(name); };
    if (has("asset")) return "a glTF";
    if (has("rings") || has("spatialReference")) return "JSON of Esri";
    return has("elements") && has("generator") ? "JSON of OpenStreetMap" : "";
}

tl::unexpected<Error> wrong_body(std::string_view kind, std::string_view accepted) {
    const bool is_malformed = kind == "empty" || kind == "text";
    return failure(is_malformed ? ErrorCode::Malformed : ErrorCode::Unsupported,
                   "the body " + std::string(kind == "empty" ? "is " : "seems to be ") + std::string(kind) +
                       "; accepted are " + std::string(accepted));
}

tl::unexpected<Error> not_json(std::string_view body, const Error& error, std::string_view accepted) {
    if (error.code != ErrorCode::Malformed || may_be_json(body)) return tl::unexpected(error);
    return wrong_body(kind_of_body(body), accepted);
}

Result<JsonDocument> parse_sample_document(std::string_view body) {
    auto document = JsonDocument::parse_features(body);
    if (!document) return not_json(body, document.error(), kOfSample);
    const std::string_view kind = kind_of_json(document->root());
    if (kind == "a glTF") return wrong_body("a glTF without meshes", kOfSample);
    if (!kind.empty() && kind != kGeoJson && kind != kTopoJson) return wrong_body(kind, kOfSample);
    return document;
}

}  // namespace ccdt::api
