// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/operation.h"

#include <algorithm>
#include <string>

#include "api/input/file_formats.h"
#include "api/map/shapefile_reader.h"
#include "api/sample/choice/choice_parser.h"
#include "api/sample/plane/sample_cost.h"
#include "api/sample/spatial/voxel_input.h"
#include "api/surface/surface_header.h"
#include "api/text/text.h"
#include "server/http/http.h"

namespace ccdt::server {
namespace {

/// Maximum size of JSON [bytes] that a connection's thread parses. Workers parse longer texts.
constexpr std::size_t kQuickToParse = 8'192;

bool is_json(std::string_view type) {
    return type == "application/json" || (type.starts_with("application/") && type.ends_with("+json"));
}

bool is_zip(std::string_view type) {
    return type == "application/zip" || type == "application/x-zip-compressed";
}

/// Whether a body of this content type may be JSON: the type is JSON, a sequence of JSON texts, or a default of client
/// programs.
bool may_hold_json(std::string_view type) {
    constexpr auto kUnspecific = std::to_array<std::string_view>(
        {"", "text/plain", "application/octet-stream", "application/x-www-form-urlencoded",
         "application/x-tgif",  // Chromium on Linux sends this type for OBJ
         "application/geo+json-seq", "application/json-seq", "application/x-ndjson", "application/jsonl"});
    return is_json(type) || std::ranges::find(kUnspecific, type) != kUnspecific.end();
}

/// Whether the body is JSON rather than a picture. The content type decides. If the type is a default of client
/// programs, the first character decides: no picture begins with `{`.
bool holds_json(const ComputeRequest& request) {
    const std::string type = media_type(request.content_type);
    return is_json(type) || (may_hold_json(type) && api::trim(request.body, " \t\r\n").starts_with('{'));
}

/// Whether a content type is that of a mesh.
bool is_mesh(std::string_view type) {
    return api::recognise_surface({}, type).has_value();
}

/// Whether a content type is that of a table with a record on each line.
bool is_table(std::string_view type) {
    return type == api::kCsv.media_type || type == "text/tab-separated-values";
}

/// Whether the body is a file with candidates.
bool holds_candidates(const Operation& operation, const ComputeRequest& request) {
    return operation.takes_candidates && api::asks_for_choice(parse_query(request.query));
}

/// Whether the body is a mesh or a file of voxels, so that the options are in the query.
bool holds_shape(const Operation& operation, const ComputeRequest& request) {
    return (operation.takes_voxels && api::is_voxel_file(request.body)) ||
           (operation.takes_meshes && api::recognise_surface(request.body, media_type(request.content_type)));
}

bool reads_json(const Operation& operation, const ComputeRequest& request) {
    return !operation.takes_pictures || holds_json(request);
}

}  // namespace

Result<api::ParsedPointer> parse_halftone(const ComputeRequest& request, const api::Limits& limits) {
    const auto kind = holds_json(request) ? api::HalftoneBody::Json : api::HalftoneBody::Picture;
    return api::parse_halftone_request(request.body, kind, parse_query(request.query), request.accept, limits);
}

Result<api::ParsedPointer> parse_sample(const ComputeRequest& request, const api::Limits& limits) {
    return api::parse_sample_request(request.body, parse_query(request.query), request.accept, limits,
                                     media_type(request.content_type));
}

Result<api::ParsedPointer> parse_analyze(const ComputeRequest& request, const api::Limits& limits) {
    return api::parse_analyze_request(request.body, parse_query(request.query), request.accept, limits,
                                      media_type(request.content_type));
}

Result<void> check(const Operation& operation, const ComputeRequest& request) {
    if (operation.takes_pictures) return {};
    const std::string type = media_type(request.content_type);
    if (may_hold_json(type) || type == "multipart/form-data" || (operation.takes_shapefiles && is_zip(type)) ||
        (operation.takes_meshes && is_mesh(type)) ||
        (operation.takes_voxels && (type == api::kNpy.media_type || type == "image/tiff")) ||
        (is_table(type) && holds_candidates(operation, request)))
        return {};
    return failure(ErrorCode::Unsupported,
                   "the type of the body must be application/json, " +
                       std::string(operation.takes_shapefiles ? "application/zip, " : "") +
                       (operation.takes_voxels ? std::string(api::kNpy.media_type) + ", image/tiff, " : "") +
                       "multipart/form-data, or that of a mesh, such as model/obj, not " + type +
                       (operation.takes_candidates ? "; with candidates=body also text/csv" : ""));
}

bool holds_shapefile(const Operation& operation, const ComputeRequest& request) {
    if (!operation.takes_shapefiles) return false;
    const std::string type = media_type(request.content_type);
    return is_zip(type) || (may_hold_json(type) && request.body.starts_with(api::kZipSignature));
}

bool may_hold_options(const Operation& operation, const ComputeRequest& request) {
    return operation.takes_pictures && holds_json(request);
}

bool is_quickly_parsed(const Operation& operation, const ComputeRequest& request) {
    return !reads_json(operation, request) || request.body.size() + request.query.size() <= kQuickToParse;
}

api::Cost cost_of_parsing(const Operation& operation, const ComputeRequest& request) {
    constexpr double kSecondsPerByte = 1e-9;
    const double seconds = static_cast<double>(request.body.size()) * kSecondsPerByte;
    if (!reads_json(operation, request)) return {0, seconds};
    if (holds_candidates(operation, request)) {
        // The shortest record, such as "1,2" and a line feed, becomes a position and the place of the record.
        constexpr std::size_t kMemoryPerByte = 16;
        constexpr double kRecordsPerByte = 10;  // time of records in CSV, relative to that of other bytes
        return {kMemoryPerByte * request.body.size(), kRecordsPerByte * seconds};
    }
    if (!holds_shape(operation, request)) return api::cost_of_parsing(request.body);
    // Densities and fixed points are lists in JSON. Each value follows a comma or a bracket, which may be encoded as
    // %2C or %5B.
    constexpr std::size_t kBytesPerValue = 64;
    std::size_t values = 0;
    char before = 0;
    for (const char c : request.query) {
        if (c == ',' || c == '[' || (before == '%' && (c == '2' || c == '5'))) ++values;
        before = c;
    }
    return {2 * request.query.size() + kBytesPerValue * values, seconds};
}

api::Cost cost_of_answering(const Operation& operation, const ComputeRequest& request,
                            const api::ParsedRequest& parsed) {
    const auto parsing = cost_of_parsing(operation, request);
    const auto computing = parsed.cost();
    return {request.body.size() + std::max(parsing.memory, computing.memory), parsing.seconds + computing.seconds,
            computing.answer};
}

}  // namespace ccdt::server
