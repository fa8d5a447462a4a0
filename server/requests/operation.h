// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string_view>

#include "api/operation/parsed_request.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "server/requests/compute_request.h"

namespace ccdt::server {

/// A row of the table of operations. All differences between operations are members here, or functions of the
/// api::ParsedRequest that `parse` returns.
struct Operation {
    std::string_view path;  ///< path of the POST route
    bool takes_pictures;    ///< accepts pictures as bodies and in forms; otherwise the body is JSON
    bool takes_shapefiles;  ///< accepts zipped shapefiles as bodies and converts them to JSON
    bool takes_meshes;      ///< accepts meshes as bodies
    bool takes_voxels;      ///< accepts files of voxels as bodies
    bool takes_candidates;  ///< accepts files of points as bodies, if an option says so
    /// Name of the form field that becomes the body; a field named `file` is accepted, too.
    std::string_view form_part;

    /// Errors: those of the parser of the operation.
    Result<api::ParsedPointer> (*parse)(const ComputeRequest& request, const api::Limits& limits);
};

Result<api::ParsedPointer> parse_halftone(const ComputeRequest& request, const api::Limits& limits);
Result<api::ParsedPointer> parse_sample(const ComputeRequest& request, const api::Limits& limits);
Result<api::ParsedPointer> parse_analyze(const ComputeRequest& request, const api::Limits& limits);

inline constexpr auto kOperations = std::to_array<Operation>({
    {"/halftone", true, false, false, false, false, "image", parse_halftone},
    {"/sample", false, true, true, true, true, "map", parse_sample},
    {"/analyze", false, false, true, false, false, "mesh", parse_analyze},
});

/// Finds the operation of a path; null if there is none.
constexpr const Operation* find_operation(std::string_view path) {
    for (const Operation& operation : kOperations) {
        if (operation.path == path) return &operation;
    }
    return nullptr;
}

/// Checks the content type, before the body is read. Errors: Unsupported.
Result<void> check(const Operation& operation, const ComputeRequest& request);

/// Whether the body is a zipped shapefile. Only the decoder process may read such a body.
bool holds_shapefile(const Operation& operation, const ComputeRequest& request);

/// Whether the body is JSON that may contain options in addition to those of the query. Other operations refuse JSON
/// with options if there is a query.
bool may_hold_options(const Operation& operation, const ComputeRequest& request);

/// Whether the thread of a connection may parse the request without a noticeable delay: JSON or a mesh, of up to 8 KiB
/// together with the query, or a picture.
bool is_quickly_parsed(const Operation& operation, const ComputeRequest& request);

/// Estimates the cost of parsing.
api::Cost cost_of_parsing(const Operation& operation, const ComputeRequest& request);

/// Estimates the cost of parsing a copy of the request and computing the answer.
api::Cost cost_of_answering(const Operation& operation, const ComputeRequest& request,
                            const api::ParsedRequest& parsed);

}  // namespace ccdt::server
